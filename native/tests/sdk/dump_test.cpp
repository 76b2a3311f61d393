#include <algorithm>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

extern "C" {
#include "../../sdk/dump.h"
}

namespace {

/** Forty bytes from 0 on, and the room behind them. */
struct Dumped {
    WITH_ROOM(uint8_t[40]) bytes;

    Dumped() {
        dump_begin(bytes.room);
        std::iota(bytes.of, bytes.of + sizeof bytes.of, uint8_t{0});
    }
    std::string log(uint32_t room = DUMP_ROOM_BYTES) {
        testing::internal::CaptureStderr();
        bool isShown = false;
        dump_once(&isShown, "MLSomeState", &bytes, sizeof bytes.of, room);
        return testing::internal::GetCapturedStderr();
    }
};

} // namespace

TEST(Dump, ShowsEachByteOfAStructAndWhatIsWrittenBehindIt) {
    Dumped dumped;
    dumped.bytes.room[0] = 0x5a;
    dumped.bytes.room[63] = 0;
    EXPECT_EQ(dumped.log(),
              "4/ml2s: dump MLSomeState 0 of 40: 000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n"
              "4/ml2s: dump MLSomeState 32 of 40: 20212223242526275aa5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5\n"
              "4/ml2s: dump MLSomeState 64 of 40: a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5\n"
              "4/ml2s: dump MLSomeState 96 of 40: a5a5a5a5a5a5a500\n");
}

TEST(Dump, IsShownOnce) {
    Dumped dumped;
    testing::internal::CaptureStderr();
    for (int i = 0; i < 2; i++)
        DUMP_ONCE("MLSomeState", dumped.bytes);
    const auto log = testing::internal::GetCapturedStderr();
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 4) << "lines of one struct with its room";
}

TEST(Dump, ShowsNothingBehindAStructWithoutRoom) {
    EXPECT_EQ(Dumped().log(0),
              "4/ml2s: dump MLSomeState 0 of 40: 000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n"
              "4/ml2s: dump MLSomeState 32 of 40: 2021222324252627\n");
}
