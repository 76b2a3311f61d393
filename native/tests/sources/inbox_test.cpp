#include <atomic>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "sensor.h"

extern "C" {
#include "../../sdk/memory.h"
}

namespace {

/** An open inbox. Nothing is mapped after its end. */
class Inbox {
  public:
    explicit Inbox(uint32_t depth) { EXPECT_EQ(ml2s_inbox_open(depth, &number_), ML2S_OK); }
    ~Inbox() {
        EXPECT_EQ(ml2s_inbox_close(number_), ML2S_OK);
        EXPECT_EQ(memory_mapped_bytes(), 0u);
    }
    Inbox(const Inbox &) = delete;
    Inbox &operator=(const Inbox &) = delete;

    /** Adds a message that is filled with the low byte of its number. */
    void add(uint32_t number, uint64_t size = 100) const {
        auto message = sized<ml2s_message>();
        ml2s_memory memory;
        ASSERT_EQ(ml2s_inbox_take(number_, size, &message.slot, &memory), ML2S_OK);
        ASSERT_GE(memory.size_bytes, size);
        std::memset(memory.data, static_cast<int>(number & 0xff), size);
        message.size_bytes = size;
        message.number = number;
        ASSERT_EQ(ml2s_inbox_add(number_, &message), ML2S_OK);
    }

    ml2s_result acquire(ml2s_message *message) const {
        *message = sized<ml2s_message>();
        return ml2s_inbox_acquire(number_, message);
    }

    void release(const ml2s_message &message) const { EXPECT_EQ(ml2s_inbox_release(number_, message.slot), ML2S_OK); }

    /** The numbers of all messages that wait, in their order. */
    std::vector<uint32_t> taken() const {
        std::vector<uint32_t> numbers;
        ml2s_message message;
        while (acquire(&message) == ML2S_OK) {
            numbers.push_back(message.number);
            release(message);
        }
        return numbers;
    }

    uint32_t number() const { return number_; }

  private:
    uint32_t number_ = 0;
};

using Numbers = std::vector<uint32_t>;

} // namespace

TEST(Inboxes, GiveMessagesInTheirOrder) {
    const Inbox inbox(5);
    for (uint32_t number = 1; number <= 5; number++) {
        inbox.add(number);
    }
    EXPECT_EQ(inbox.taken(), (Numbers{1, 2, 3, 4, 5}));
    EXPECT_EQ(inbox.taken(), Numbers{});
}

TEST(Inboxes, DropTheOldestAndCountIt) {
    const Inbox inbox(2);
    for (uint32_t number = 1; number <= 5; number++) {
        inbox.add(number);
    }
    ml2s_message message;
    ASSERT_EQ(inbox.acquire(&message), ML2S_OK);
    EXPECT_EQ(message.number, 4u);
    EXPECT_EQ(message.left_out, 3u);
    inbox.release(message);
    EXPECT_EQ(inbox.taken(), Numbers{5});
}

TEST(Inboxes, KeepTheNewestOnly) {
    const Inbox inbox(1);
    inbox.add(1);
    inbox.add(2);
    EXPECT_EQ(inbox.taken(), Numbers{2});
}

TEST(Inboxes, LeaveALeasedMessageAsItIs) {
    const Inbox inbox(1);
    inbox.add(7);
    ml2s_message message;
    ASSERT_EQ(inbox.acquire(&message), ML2S_OK);
    for (uint32_t number = 8; number < 20; number++) {
        inbox.add(number, 3000);
    }
    EXPECT_EQ(message.size_bytes, 100u);
    EXPECT_EQ(std::vector<uint8_t>(message.data, message.data + 100), std::vector<uint8_t>(100, 7));
    inbox.release(message);
    EXPECT_EQ(ml2s_inbox_release(inbox.number(), message.slot), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(inbox.taken(), Numbers{19});
}

TEST(Inboxes, SkipAllButTheNewest) {
    const Inbox inbox(9);
    EXPECT_EQ(ml2s_inbox_skip(inbox.number()), ML2S_OK);
    for (uint32_t number = 1; number <= 5; number++) {
        inbox.add(number);
    }
    EXPECT_EQ(ml2s_inbox_skip(inbox.number()), ML2S_OK);
    EXPECT_EQ(inbox.taken(), Numbers{5});
    ml2s_message message;
    EXPECT_EQ(inbox.acquire(&message), ML2S_TIMEOUT);
    EXPECT_EQ(message.left_out, 4u);
}

TEST(Inboxes, UseTheirMemoryAgain) {
    const Inbox inbox(2);
    for (uint32_t number = 0; number < 9; number++) {
        inbox.add(number, 1 << 20);
    }
    const uint64_t mapped = memory_mapped_bytes();
    EXPECT_GT(mapped, 3u << 20);
    for (uint32_t number = 0; number < 99; number++) {
        inbox.add(number, (1 << 20) + number);
    }
    EXPECT_EQ(memory_mapped_bytes(), mapped);
}

TEST(Inboxes, AreClosedWithALeaseLeft) {
    uint32_t number = 0;
    ml2s_message leased;
    uint32_t taken;
    ml2s_memory memory;
    {
        uint32_t other;
        ASSERT_EQ(ml2s_inbox_open(3, &number), ML2S_OK);
        ASSERT_EQ(ml2s_inbox_take(number, 10, &other, &memory), ML2S_OK);
        auto message = sized<ml2s_message>();
        message.slot = other;
        message.size_bytes = 10;
        ASSERT_EQ(ml2s_inbox_add(number, &message), ML2S_OK);
        leased = sized<ml2s_message>();
        ASSERT_EQ(ml2s_inbox_acquire(number, &leased), ML2S_OK);
        ASSERT_EQ(ml2s_inbox_take(number, 10, &taken, &memory), ML2S_OK);
        EXPECT_EQ(ml2s_inbox_close(number), ML2S_OK);
    }
    leased.data[9] = 1;
    memory.data[9] = 1;
    uint32_t next = 0;
    EXPECT_EQ(ml2s_inbox_open(1, &next), ML2S_OK);
    EXPECT_NE(next % ML2S_MOST_INBOXES, number % ML2S_MOST_INBOXES) << "its slots are leased";
    EXPECT_EQ(ml2s_inbox_close(next), ML2S_OK);
    auto message = sized<ml2s_message>();
    message.slot = taken;
    message.size_bytes = 10;
    EXPECT_EQ(ml2s_inbox_add(number, &message), ML2S_CLOSED);
    EXPECT_EQ(ml2s_inbox_release(number, leased.slot), ML2S_OK);
    EXPECT_EQ(memory_mapped_bytes(), 0u);
    EXPECT_EQ(ml2s_inbox_acquire(number, &message), ML2S_CLOSED);
    EXPECT_EQ(ml2s_inbox_close(number), ML2S_CLOSED);
}

TEST(Inboxes, AreBounded) {
    std::vector<uint32_t> open(ML2S_MOST_INBOXES);
    for (auto &number : open) {
        EXPECT_EQ(ml2s_inbox_open(1, &number), ML2S_OK);
    }
    uint32_t number = 0;
    EXPECT_EQ(ml2s_inbox_open(1, &number), ML2S_BUSY);
    for (const auto each : open) {
        EXPECT_EQ(ml2s_inbox_close(each), ML2S_OK);
    }
}

TEST(Inboxes, RefuseWhatTheyCannotHold) {
    uint32_t number = 0;
    EXPECT_EQ(ml2s_inbox_open(0, &number), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_inbox_open(ML2S_MOST_INBOX_DEPTH + 1, &number), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_inbox_open(1, nullptr), ML2S_INVALID_ARGUMENT);
    const Inbox inbox(1);
    uint32_t slot = 0;
    ml2s_memory memory;
    EXPECT_EQ(ml2s_inbox_take(inbox.number(), 0, &slot, &memory), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_inbox_take(inbox.number(), UINT64_C(1) << 62, &slot, &memory), ML2S_ALL_SLOTS_LEASED);
    ASSERT_EQ(ml2s_inbox_take(inbox.number(), 10, &slot, &memory), ML2S_OK);
    auto message = sized<ml2s_message>();
    message.slot = slot;
    message.size_bytes = memory.size_bytes + 1;
    EXPECT_EQ(ml2s_inbox_add(inbox.number(), &message), ML2S_INVALID_ARGUMENT);
    message.slot = ML2S_MOST_INBOX_DEPTH + 2;
    EXPECT_EQ(ml2s_inbox_add(inbox.number(), &message), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_inbox_release(inbox.number(), UINT32_MAX), ML2S_INVALID_ARGUMENT);
    EXPECT_EQ(ml2s_inbox_release(inbox.number(), slot), ML2S_OK);
}

TEST(Inboxes, EndAWaitByAMessageAndByTheirEnd) {
    auto inbox = std::make_unique<Inbox>(3);
    const uint32_t number = inbox->number();
    std::atomic<uint32_t> waits = 0;
    std::thread reader([&] {
        auto message = sized<ml2s_message>();
        while (ml2s_inbox_wait(number) == ML2S_OK) {
            EXPECT_EQ(ml2s_inbox_acquire(number, &message), ML2S_OK);
            EXPECT_EQ(message.number, ++waits);
            EXPECT_EQ(ml2s_inbox_release(number, message.slot), ML2S_OK);
        }
    });
    for (uint32_t each = 1; each <= 2000; each++) {
        inbox->add(each);
        while (waits < each) {
            std::this_thread::yield();
        }
    }
    inbox.reset();
    reader.join();
    EXPECT_EQ(ml2s_inbox_wait(number), ML2S_CLOSED);
}

TEST(Inboxes, LoseNothingUncountedBetweenTwoThreads) {
    constexpr uint32_t kMessages = 20000;
    const Inbox inbox(3);
    std::thread writer([&] {
        for (uint32_t number = 1; number <= kMessages; number++) {
            inbox.add(number, 1 + number % 5000);
        }
    });
    uint32_t last = 0, count = 0;
    ml2s_message message;
    while (last < kMessages) {
        if (inbox.acquire(&message) != ML2S_OK) {
            std::this_thread::yield();
            continue;
        }
        EXPECT_GT(message.number, last);
        last = message.number;
        count++;
        EXPECT_EQ(message.size_bytes, 1 + last % 5000);
        EXPECT_EQ(message.data[0], last & 0xff);
        EXPECT_EQ(message.data[message.size_bytes - 1], last & 0xff);
        inbox.release(message);
    }
    writer.join();
    EXPECT_EQ(inbox.acquire(&message), ML2S_TIMEOUT);
    EXPECT_EQ(count + message.left_out, kMessages);
}
