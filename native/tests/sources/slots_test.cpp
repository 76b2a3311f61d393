#include <algorithm>
#include <atomic>
#include <cstring>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

#include "sensor.h"

extern "C" {
#include "../../sdk/memory.h"
#include "../../sources/slots.h"
}

namespace {

constexpr uint32_t kStream = ML2S_STREAM_COLOR;
constexpr uint32_t kWords = 16;
constexpr size_t kSlotBytes = kWords * sizeof(uint32_t);

std::optional<uint32_t> take() {
    uint32_t slot;
    ml2s_memory memory;
    return ml2s_take(kStream, kSlotBytes, &slot, &memory) == ML2S_OK ? std::optional(slot) : std::nullopt;
}

ml2s_result publish(uint32_t slot, int64_t capture_nanos) {
    auto frame = sized<ml2s_frame>();
    frame.stream = kStream;
    frame.slot = slot;
    frame.capture_nanos = capture_nanos;
    return ml2s_publish(&frame);
}

std::optional<ml2s_frame> acquire(int64_t after_nanos) {
    auto frame = sized<ml2s_frame>();
    return ml2s_acquire_latest(kStream, after_nanos, &frame) == ML2S_OK ? std::optional(frame) : std::nullopt;
}

/** Takes, publishes and releases one slot. */
void publishOnce(int64_t capture_nanos) {
    const auto slot = take();
    ASSERT_TRUE(slot);
    EXPECT_EQ(publish(*slot, capture_nanos), ML2S_OK);
    EXPECT_EQ(ml2s_release(kStream, *slot), ML2S_OK);
}

} // namespace

TEST(Slots, AStreamWithoutSlotsHasNoneToTakeAndNothingLatest) {
    EXPECT_FALSE(take());
    EXPECT_FALSE(acquire(INT64_MIN));
}

TEST(Slots, EverySlotIsTakenOnceUntilItIsReleased) {
    const Slots slots(kStream);
    std::set<uint32_t> taken;
    for (uint32_t i = 0; i < ML2S_MAX_SLOTS; i++) {
        const auto slot = take();
        ASSERT_TRUE(slot && taken.insert(*slot).second) << i;
    }
    EXPECT_FALSE(take());
    EXPECT_EQ(ml2s_release(kStream, 1), ML2S_OK);
    EXPECT_EQ(take(), 1u);
    for (const auto slot : taken) {
        EXPECT_EQ(ml2s_release(kStream, slot), ML2S_OK);
    }
}

TEST(Slots, ThePublishedFrameIsLeasedWithItsMemoryUntilEveryReaderReleases) {
    const Slots slots(kStream, 1);
    publishOnce(100);
    const auto first = acquire(0);
    const auto second = acquire(99);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->capture_nanos, 100);
    EXPECT_EQ(first->data, second->data);
    EXPECT_EQ(ml2s_unpublish(kStream), ML2S_OK);
    EXPECT_EQ(ml2s_release(kStream, first->slot), ML2S_OK);
    EXPECT_FALSE(take()) << "the second reads on";
    EXPECT_EQ(ml2s_release(kStream, second->slot), ML2S_OK);
    EXPECT_EQ(ml2s_release(kStream, second->slot), ML2S_INVALID_ARGUMENT) << "nobody has a lease to end";
}

TEST(Slots, AnUnpublishedFrameIsAcquiredNoMoreAndItsReadersKeepIt) {
    const Slots slots(kStream, 1);
    publishOnce(100);
    const auto leased = acquire(0);
    ASSERT_TRUE(leased);
    EXPECT_EQ(ml2s_unpublish(kStream), ML2S_OK);
    EXPECT_FALSE(acquire(0));
    EXPECT_FALSE(take()) << "it is being read";
    EXPECT_EQ(ml2s_release(kStream, leased->slot), ML2S_OK);
    publishOnce(200);
    EXPECT_EQ(ml2s_unpublish(kStream), ML2S_OK);
    EXPECT_EQ(ml2s_unpublish(kStream), ML2S_OK) << "there is none";
    const auto slot = take();
    ASSERT_TRUE(slot) << "it is kept for nobody";
    EXPECT_EQ(ml2s_release(kStream, *slot), ML2S_OK);
}

TEST(Slots, OnlyNewerFramesAreAcquired) {
    const Slots slots(kStream, 2);
    publishOnce(100);
    EXPECT_FALSE(acquire(100));
    publishOnce(200);
    const auto frame = acquire(100);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->capture_nanos, 200);
    EXPECT_EQ(ml2s_release(kStream, frame->slot), ML2S_OK);
}

TEST(Slots, TheLatestIsKeptWhileOthersAreTaken) {
    const Slots slots(kStream, 2);
    publishOnce(100);
    const auto other = take();
    ASSERT_TRUE(other);
    EXPECT_FALSE(take());
    EXPECT_EQ(publish(*other, 200), ML2S_OK);
    const auto first = take();
    ASSERT_TRUE(first) << "the old latest is free again";
    EXPECT_EQ(ml2s_release(kStream, *other), ML2S_OK);
    EXPECT_EQ(ml2s_release(kStream, *first), ML2S_OK);
}

TEST(Slots, AFrameIsPublishedOnceAndOnlyByItsWriter) {
    const Slots slots(kStream);
    EXPECT_EQ(publish(0, 1), ML2S_INVALID_ARGUMENT);
    ASSERT_EQ(take(), 0u);
    EXPECT_EQ(publish(0, 1), ML2S_OK);
    EXPECT_EQ(publish(0, 2), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_release(kStream, 0), ML2S_OK);
}

TEST(Slots, AWriterMayGiveUp) {
    const Slots slots(kStream);
    ASSERT_EQ(take(), 0u);
    EXPECT_EQ(ml2s_release(kStream, 0), ML2S_OK);
    EXPECT_EQ(publish(0, 1), ML2S_INVALID_ARGUMENT);
    EXPECT_FALSE(acquire(INT64_MIN));
}

TEST(Slots, MisuseIsRefused) {
    const Slots slots(kStream);
    uint32_t slot;
    ml2s_memory memory;
    auto frame = sized<ml2s_frame>();
    frame.slot = ML2S_MAX_SLOTS;
    EXPECT_EQ(ml2s_take(ML2S_STREAM_COUNT, 64, &slot, &memory), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_take(kStream, 0, &slot, &memory), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_take(kStream, 64, nullptr, &memory), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_take(kStream, 64, &slot, nullptr), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_publish(&frame), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_publish(nullptr), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_release(kStream, ML2S_MAX_SLOTS), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_release(kStream, 0), ML2S_INVALID_ARGUMENT);
    frame.struct_size--;
    EXPECT_EQ(ml2s_acquire_latest(kStream, 0, &frame), ML2S_INVALID_ARGUMENT);
}

TEST(Slots, MemoryThatTheSystemDoesNotHaveLosesTheFrame) {
    const Slots slots(kStream, 1);
    uint32_t slot;
    ml2s_memory memory;
    EXPECT_EQ(ml2s_take(kStream, uint64_t{1} << 60, &slot, &memory), ML2S_ALL_SLOTS_LEASED);
    publishOnce(100);
}

namespace {

/** Writes frame numbers into slots as fast as slots come free, until enough were read; returns how many were lost. */
int64_t write(const std::atomic<int> &reads, int enough) {
    int64_t lost = 0;
    for (int64_t number = 1; reads < enough; number++) {
        uint32_t slot;
        ml2s_memory memory;
        if (ml2s_take(kStream, kSlotBytes, &slot, &memory)) {
            lost++;
            std::this_thread::yield();
            continue;
        }
        auto *words = reinterpret_cast<uint32_t *>(memory.data);
        for (uint32_t i = 0; i < kWords; i++) {
            words[i] = static_cast<uint32_t>(number);
        }
        EXPECT_EQ(publish(slot, number), ML2S_OK);
        EXPECT_EQ(ml2s_release(kStream, slot), ML2S_OK);
    }
    return lost;
}

/** Checks that a reader sees one whole frame. */
void expectWhole(const ml2s_frame &frame) {
    const auto *words = reinterpret_cast<const uint32_t *>(frame.data);
    for (uint32_t i = 0; i < kWords; i++) {
        ASSERT_EQ(words[i], frame.capture_nanos);
    }
}

/** Reads until the writer is done. A slow reader lets the writer publish twice before it looks at its frame. */
void read(const std::atomic<bool> &isDone, bool isSlow, std::atomic<int> &reads) {
    int64_t last = 0;
    while (!isDone) {
        const auto frame = acquire(last);
        if (!frame) {
            std::this_thread::yield();
            continue;
        }
        EXPECT_GT(frame->capture_nanos, last);
        last = frame->capture_nanos;
        for (int published = 0; isSlow && published < 2 && !isDone;) {
            if (const auto newer = acquire(last + published)) {
                published++;
                EXPECT_EQ(ml2s_release(kStream, newer->slot), ML2S_OK);
            }
            std::this_thread::yield();
        }
        expectWhole(*frame);
        EXPECT_EQ(ml2s_release(kStream, frame->slot), ML2S_OK);
        reads++;
    }
}

/** Takes a lease, and ends without giving it back; whoever owned the thread does. */
void leaseAndDie(std::optional<ml2s_frame> &leased, const std::atomic<bool> &isDone) {
    while (!leased && !isDone) {
        leased = acquire(0);
    }
}

} // namespace

TEST(Slots, SlowFastAndDyingReadersSeeWholeFramesAndTheWriterNeverWaits) {
    const Slots slots(kStream, 6);
    std::atomic<bool> isDone = false;
    std::optional<ml2s_frame> leased;
    std::thread dying([&] { leaseAndDie(leased, isDone); });
    std::atomic<int> slowReads = 0, fastReads = 0;
    std::thread slow([&] { read(isDone, true, slowReads); });
    std::thread fast([&] { read(isDone, false, fastReads); });
    const int64_t lost = write(fastReads, 1000);
    isDone = true;
    for (auto *thread : {&dying, &slow, &fast}) {
        thread->join();
    }
    EXPECT_EQ(lost, 0) << "six slots: the latest, the writer's, two of slow, one each of fast and dying";
    if (leased) {
        expectWhole(*leased);
        EXPECT_EQ(ml2s_release(kStream, leased->slot), ML2S_OK);
    }
}

TEST(Slots, StreamsEndAndBeginWhileFramesAreWrittenAndRead) {
    std::atomic<bool> isDone = false;
    std::atomic<int> reads = 0;
    std::thread reader([&] { read(isDone, false, reads); });
    std::thread writer([&] {
        write(reads, 100);
        isDone = true;
    });
    while (!isDone) {
        ASSERT_EQ(ml2s_reserve(kStream), ML2S_OK);
        for (const int before = reads; reads == before && !isDone;) {
            std::this_thread::yield();
        }
        ASSERT_EQ(ml2s_retire(kStream), ML2S_OK);
    }
    writer.join();
    reader.join();
    EXPECT_EQ(memory_mapped_bytes(), 0u);
}

namespace {

constexpr uint64_t kPicture = 1 << 20;

/** Reserves the slots of the stream, whose memory is the library's. */
class Reserved {
  public:
    Reserved() { EXPECT_EQ(ml2s_reserve(kStream), ML2S_OK); }
    ~Reserved() {
        if (isReserved_) {
            end();
        }
        EXPECT_EQ(memory_mapped_bytes(), 0u) << "memory that nobody reads any more";
    }
    Reserved(const Reserved &) = delete;
    Reserved &operator=(const Reserved &) = delete;

    void end() {
        isReserved_ = false;
        EXPECT_EQ(ml2s_retire(kStream), ML2S_OK);
    }

  private:
    bool isReserved_ = true;
};

/** A taken slot that is full of value. */
ml2s_frame filled(uint64_t size_bytes, uint8_t value) {
    auto frame = sized<ml2s_frame>();
    ml2s_memory memory = {};
    frame.stream = kStream;
    frame.capture_nanos = value;
    EXPECT_EQ(ml2s_take(kStream, size_bytes, &frame.slot, &memory), ML2S_OK);
    EXPECT_EQ(memory.size_bytes, size_bytes);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(memory.data) % 64, 0u);
    std::memset(memory.data, value, size_bytes);
    frame.data = memory.data;
    return frame;
}

void expectFilled(const ml2s_frame &frame, uint64_t size_bytes) {
    for (uint64_t i = 0; i < size_bytes; i += 4096) {
        ASSERT_EQ(frame.data[i], frame.capture_nanos);
    }
}

void giveBack(const ml2s_frame &frame) { EXPECT_EQ(ml2s_release(kStream, frame.slot), ML2S_OK); }

} // namespace

TEST(ReservedSlots, HaveMemoryOnlyOnceFramesNeedIt) {
    const Reserved reserved;
    EXPECT_EQ(memory_mapped_bytes(), 0u);
    giveBack(filled(kPicture, 1));
    giveBack(filled(kPicture, 2));
    EXPECT_EQ(memory_mapped_bytes(), kPicture) << "one slot was enough for both";
    const auto first = filled(kPicture, 3), second = filled(kPicture, 4);
    EXPECT_EQ(memory_mapped_bytes(), 2 * kPicture);
    giveBack(first);
    giveBack(second);
}

TEST(ReservedSlots, AnEndedStreamsMemoryGoesWithItsLastLease) {
    Reserved reserved;
    const auto written = filled(kPicture, 7);
    EXPECT_EQ(ml2s_publish(&written), ML2S_OK);
    const auto read = acquire(0);
    ASSERT_TRUE(read);
    reserved.end();
    EXPECT_FALSE(acquire(0)) << "no frame of an ended stream is the latest";
    EXPECT_EQ(memory_mapped_bytes(), kPicture);
    giveBack(written);
    expectFilled(*read, kPicture);
    EXPECT_EQ(memory_mapped_bytes(), kPicture);
    giveBack(*read);
    EXPECT_EQ(memory_mapped_bytes(), 0u);
    EXPECT_EQ(ml2s_release(kStream, read->slot), ML2S_INVALID_ARGUMENT);
}

TEST(ReservedSlots, TheLatestFrameOfAnEndedStreamIsKeptForNobody) {
    Reserved reserved;
    const auto written = filled(kPicture, 7);
    EXPECT_EQ(ml2s_publish(&written), ML2S_OK);
    giveBack(written);
    EXPECT_EQ(memory_mapped_bytes(), kPicture);
    reserved.end();
    EXPECT_EQ(memory_mapped_bytes(), 0u);
}

TEST(ReservedSlots, AFrameThatIsPublishedTooLateIsKeptForNobody) {
    Reserved reserved;
    const auto written = filled(kPicture, 7);
    reserved.end();
    EXPECT_EQ(ml2s_publish(&written), ML2S_OK);
    giveBack(written);
    EXPECT_EQ(memory_mapped_bytes(), 0u);
    EXPECT_FALSE(acquire(0));
}

TEST(ReservedSlots, AStreamThatBeginsAnewKeepsWhatIsStillRead) {
    Reserved reserved;
    const auto kept = filled(kPicture, 7);
    reserved.end();
    const Reserved again;
    const auto fresh = filled(kPicture, 8);
    EXPECT_NE(fresh.slot, kept.slot);
    expectFilled(kept, kPicture);
    giveBack(fresh);
    giveBack(kept);
    EXPECT_EQ(memory_mapped_bytes(), 2 * kPicture) << "both are the new stream's";
}

TEST(ReservedSlots, AnotherModeReplacesTheMemoryOfTheLastOne) {
    const Reserved reserved;
    const auto kept = filled(2 * kPicture, 1), other = filled(2 * kPicture, 2);
    giveBack(other);
    const auto small = filled(kPicture / 2, 3);
    EXPECT_EQ(memory_mapped_bytes(), 2 * kPicture + kPicture / 2) << "the frame that is read, and the new one";
    expectFilled(kept, 2 * kPicture);
    giveBack(small);
    giveBack(kept);
    const auto next = filled(kPicture / 2, 4), last = filled(kPicture / 2, 5);
    EXPECT_EQ(memory_mapped_bytes(), kPicture);
    giveBack(next);
    giveBack(last);
}

TEST(ReservedSlots, AreKeptUntilEveryReservationHasEnded) {
    Reserved reserved;
    {
        EXPECT_EQ(ml2s_reserve(kStream), ML2S_OK);
        giveBack(filled(kPicture, 1));
        EXPECT_EQ(ml2s_retire(kStream), ML2S_OK);
    }
    EXPECT_EQ(memory_mapped_bytes(), kPicture);
    reserved.end();
    EXPECT_EQ(ml2s_retire(kStream), ML2S_INVALID_ARGUMENT);
}

/** A reader of the same process, such as C#, has no part in when streams end: its memory must stay all the same. */
TEST(ReservedSlots, ReadersKeepTheirFramesWhileStreamsEndBeginAndChangeTheirMode) {
    std::atomic<bool> isDone = false;
    std::atomic<int> reads = 0;
    const auto readAll = [&] {
        while (!isDone) {
            const auto frame = acquire(0);
            if (!frame) {
                std::this_thread::yield();
                continue;
            }
            for (int look = 0; look < 3; look++) {
                expectFilled(*frame, frame->planes[0].size_bytes);
                std::this_thread::yield();
            }
            giveBack(*frame);
            reads++;
        }
    };
    std::thread first(readAll), second(readAll);
    for (uint8_t value = 1; reads < 300; value = static_cast<uint8_t>(value % 100 + 1)) {
        ASSERT_EQ(ml2s_reserve(kStream), ML2S_OK);
        for (uint64_t size = kPicture / 8; size >= kPicture / 32; size /= 2) {
            uint32_t slot;
            ml2s_memory memory;
            if (ml2s_take(kStream, size, &slot, &memory)) {
                continue;
            }
            auto frame = sized<ml2s_frame>();
            frame.stream = kStream;
            frame.slot = slot;
            frame.capture_nanos = value;
            frame.planes[0].size_bytes = static_cast<uint32_t>(size);
            std::memset(memory.data, value, size);
            EXPECT_EQ(ml2s_publish(&frame), ML2S_OK);
            std::this_thread::yield();
            giveBack(frame);
        }
        ASSERT_EQ(ml2s_retire(kStream), ML2S_OK);
    }
    isDone = true;
    first.join();
    second.join();
    EXPECT_EQ(memory_mapped_bytes(), 0u);
}

TEST(EncodedSlots, AreBesideThoseOfTheFrames) {
    constexpr uint32_t kEncoded = kStream | ML2S_ENCODED;
    Reserved reserved;
    EXPECT_EQ(ml2s_reserve(kEncoded), ML2S_OK);
    const auto frame = filled(kPicture, 1);
    EXPECT_EQ(ml2s_publish(&frame), ML2S_OK);
    uint32_t slots[ML2S_MAX_SLOTS];
    for (auto &slot : slots) {
        ml2s_memory memory;
        ASSERT_EQ(ml2s_take(kEncoded, 100, &slot, &memory), ML2S_OK);
        std::memset(memory.data, 9, 100);
    }
    uint32_t none;
    ml2s_memory memory;
    EXPECT_EQ(ml2s_take(kEncoded, 100, &none, &memory), ML2S_ALL_SLOTS_LEASED);
    const auto latest = acquire(0);
    ASSERT_TRUE(latest);
    EXPECT_EQ(latest->stream, kStream);
    expectFilled(*latest, kPicture);
    giveBack(*latest);
    giveBack(frame);
    reserved.end();
    EXPECT_EQ(slots_memory(kEncoded, slots[3]).data[99], 9) << "the frames' slots ended, these did not";
    EXPECT_EQ(ml2s_retire(kEncoded), ML2S_OK);
    for (uint32_t slot : slots) {
        EXPECT_EQ(ml2s_release(kEncoded, slot), ML2S_OK);
        EXPECT_EQ(ml2s_release(kEncoded, slot), ML2S_INVALID_ARGUMENT);
    }
    EXPECT_EQ(memory_mapped_bytes(), 0u);
}

TEST(EncodedSlots, TakePagesOfWhatIsWrittenOnly) {
    constexpr uint32_t kEncoded = kStream | ML2S_ENCODED;
    constexpr uint64_t kMost = 1 << 22, kWritten = 10000;
    const auto page = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
    EXPECT_EQ(ml2s_reserve(kEncoded), ML2S_OK);
    uint32_t slot;
    ml2s_memory memory;
    ASSERT_EQ(ml2s_take(kEncoded, kMost, &slot, &memory), ML2S_OK);
    ASSERT_EQ(madvise(memory.data, memory.size_bytes, MADV_NOHUGEPAGE), 0);
    std::memset(memory.data, 1, kWritten);
    std::vector<unsigned char> isResident(kMost / page);
    ASSERT_EQ(mincore(memory.data, kMost, isResident.data()), 0);
    EXPECT_EQ(std::count(isResident.begin(), isResident.end(), 1), static_cast<std::ptrdiff_t>(kWritten / page + 1));
    EXPECT_EQ(ml2s_retire(kEncoded), ML2S_OK);
    EXPECT_EQ(ml2s_release(kEncoded, slot), ML2S_OK);
}

TEST(EncodedSlots, AreOfStreamsThatExist) {
    for (uint32_t stream : {static_cast<uint32_t>(ML2S_STREAM_COUNT), ML2S_STREAM_COUNT | ML2S_ENCODED,
                            kStream | 2 * ML2S_ENCODED, kStream | 3 * ML2S_ENCODED, UINT32_MAX}) {
        EXPECT_EQ(ml2s_reserve(stream), ML2S_INVALID_ARGUMENT);
        EXPECT_EQ(ml2s_retire(stream), ML2S_INVALID_ARGUMENT);
        EXPECT_EQ(ml2s_release(stream, 0), ML2S_INVALID_ARGUMENT);
        EXPECT_EQ(ml2s_unpublish(stream), ML2S_INVALID_ARGUMENT);
        uint32_t slot;
        ml2s_memory memory;
        EXPECT_EQ(ml2s_take(stream, 64, &slot, &memory), ML2S_INVALID_ARGUMENT);
        EXPECT_EQ(slots_memory(stream, 0).data, nullptr);
    }
}
