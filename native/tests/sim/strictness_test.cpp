// Calls that every camera refuses, and how they are counted.
#include <future>
#include <thread>

#include "cameras_fixture.h"

template <typename Port> class Strictness : public Cameras<Port> {};
TYPED_TEST_SUITE(Strictness, AllPorts);

TYPED_TEST(Strictness, APerfectClientLeavesEmptyBooks) { this->connectAndGet(); }

TYPED_TEST(Strictness, SettingsOfAnotherVersionAreRefused) {
    auto settings = TypeParam::settings();
    settings.version += 1;
    EXPECT_EQ(TypeParam::connect(&settings, &this->handle), MLResult_InvalidParam);
    this->expectMisuse(ML2SIM_MISUSE_VERSION);
}

TYPED_TEST(Strictness, DataThatWasNotInitialisedIsRefused) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    this->data.version = 0;
    EXPECT_EQ(this->get(), MLResult_InvalidParam);
    this->expectMisuse(ML2SIM_MISUSE_VERSION);
}

TYPED_TEST(Strictness, NullIsRefused) {
    const auto settings = TypeParam::settings();
    EXPECT_EQ(TypeParam::connect(nullptr, &this->handle), MLResult_InvalidParam);
    EXPECT_EQ(TypeParam::connect(&settings, nullptr), MLResult_InvalidParam);
    ASSERT_EQ(this->connect(), MLResult_Ok);
    EXPECT_EQ(TypeParam::get(this->handle, 0, nullptr), MLResult_InvalidParam);
    EXPECT_EQ(TypeParam::updateSettings(this->handle, nullptr), MLResult_InvalidParam);
    this->expectMisuse(ML2SIM_MISUSE_ARGUMENT, 4);
}

TYPED_TEST(Strictness, AClosedHandleStaysInvalid) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    const auto closed = this->handle;
    this->disconnect();
    EXPECT_EQ(this->disconnect(), MLResult_InvalidParam);
    ASSERT_EQ(this->connect(), MLResult_Ok);
    EXPECT_NE(this->handle, closed);
    EXPECT_EQ(TypeParam::get(closed, 0, &this->data), MLResult_InvalidParam);
    EXPECT_EQ(TypeParam::get(0, 0, &this->data), MLResult_InvalidParam);
    this->expectMisuse(ML2SIM_MISUSE_HANDLE, 3);
}

TYPED_TEST(Strictness, AnotherThreadIsRefused) {
    this->connectAndGet();
    std::thread([this] {
        EXPECT_EQ(this->release(), MLResult_IllegalState);
        EXPECT_EQ(this->disconnect(), MLResult_IllegalState);
    }).join();
    this->expectMisuse(ML2SIM_MISUSE_THREAD, 2);
}

TYPED_TEST(Strictness, ASecondThreadIsRefusedWhileTheFirstWaits) {
    std::promise<void> connected;
    auto owner = std::async(std::launch::async, [&] {
        ASSERT_EQ(this->connect(), MLResult_Ok);
        connected.set_value();
        EXPECT_EQ(this->get(1000), MLResult_Ok);
        this->releaseAndDisconnect();
    });
    connected.get_future().wait();
    auto other = TypeParam::data();
    EXPECT_EQ(TypeParam::get(this->handle, 0, &other), MLResult_IllegalState);
    ml2sim_advance(100 * kMillisecond);
    owner.get();
    this->expectMisuse(ML2SIM_MISUSE_THREAD);
}

TYPED_TEST(Strictness, AGetBeforeTheReleaseOfTheLastIsRefused) {
    this->connectAndGet();
    ml2sim_advance(100 * kMillisecond);
    auto other = TypeParam::data();
    EXPECT_EQ(TypeParam::get(this->handle, 0, &other), MLResult_IllegalState);
    this->expectMisuse(ML2SIM_MISUSE_GET_TWICE);
}

TYPED_TEST(Strictness, OnlyWhatWasGotIsReleasedAndOnlyOnce) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    EXPECT_EQ(this->release(), MLResult_InvalidParam);
    ml2sim_advance(100 * kMillisecond);
    ASSERT_EQ(this->get(), MLResult_Ok);
    auto other = TypeParam::data();
    EXPECT_EQ(TypeParam::release(this->handle, &other), MLResult_InvalidParam);
    EXPECT_EQ(this->release(), MLResult_Ok);
    EXPECT_EQ(this->release(), MLResult_InvalidParam);
    this->expectMisuse(ML2SIM_MISUSE_RELEASE, 3);
}

TYPED_TEST(Strictness, DisconnectingWithDataIsToldAndDisconnects) {
    this->connectAndGet();
    EXPECT_EQ(counters().outstanding_gets, 1u);
    EXPECT_EQ(this->disconnect(), MLResult_Ok);
    this->expectMisuse(ML2SIM_MISUSE_UNRELEASED);
}

TYPED_TEST(Strictness, ACameraHasOneClient) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    const auto settings = TypeParam::settings();
    MLHandle second = 0;
    EXPECT_EQ(TypeParam::connect(&settings, &second), MLResult_UnspecifiedFailure);
    EXPECT_EQ(second, ML_INVALID_HANDLE);
    this->expectMisuse(ML2SIM_MISUSE_CLIENTS);
}

TYPED_TEST(Strictness, AnOpenHandleShowsInTheBooks) {
    ASSERT_EQ(this->connect(), MLResult_Ok);
    EXPECT_EQ(counters().open_handles, 1u);
}

TYPED_TEST(Strictness, ReleasedPixelsCannotBeTouched) {
    this->connectAndGet();
    const auto *pixels = static_cast<const volatile uint8_t *>(TypeParam::buffer(this->data).data);
    ASSERT_EQ(this->release(), MLResult_Ok);
    EXPECT_DEATH((void)*pixels, "");
    ml2sim_advance(100 * kMillisecond);
    ASSERT_EQ(this->get(), MLResult_Ok);
    EXPECT_DEATH((void)*pixels, "") << "a stale pointer must not find the next frame";
}

TYPED_TEST(Strictness, MisuseAbortsWhenAskedTo) {
    testing::FLAGS_gtest_death_test_style = "threadsafe"; // A fork is another thread than the one that connected.
    ASSERT_EQ(this->connect(), MLResult_Ok);
    set("abort_on_misuse", "1");
    EXPECT_DEATH(this->release(), "misuse: .* nothing is got");
    set("abort_on_misuse", "0");
}
