// Covers base/assertions.cpp.
#include "base/assertions.h"

#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive {
namespace {

// Each tier separately, in every build type.
#pragma push_macro("SPRINGDRIVE_AUDIT")
#undef SPRINGDRIVE_AUDIT
#define SPRINGDRIVE_AUDIT 1
void audit(int &asked, int value) { SPRINGDRIVE_ASSERT_AUDIT(++asked > 0 && value > 0); }
#undef SPRINGDRIVE_AUDIT
#define SPRINGDRIVE_AUDIT 0
void leave_out(int &asked, int value) { SPRINGDRIVE_ASSERT_AUDIT(++asked > 0 && value > 0); }
#pragma pop_macro("SPRINGDRIVE_AUDIT")

constexpr int half(int value) {
    SPRINGDRIVE_ASSERT(value % 2 == 0);
    SPRINGDRIVE_ASSERT_AUDIT(value % 2 == 0);
    return value / 2;
}
static_assert(half(6) == 3);

void need_positive(int value) noexcept { SPRINGDRIVE_ASSERT(value > 0); }
constexpr int kLineOfNeed = __LINE__ - 1;

void need_pair(std::pair<int, int> pair) { SPRINGDRIVE_ASSERT(pair == std::pair<int, int>{1, 2}); }

using AssertionsDeathTest = ::testing::Test;

TEST(Assertions, EvaluatesAHoldingConditionOnce) {
    int asked = 0;
    SPRINGDRIVE_ASSERT(++asked == 1);
    EXPECT_EQ(asked, 1);
    need_positive(1);
    need_pair({1, 2});
    EXPECT_EQ(half(4), 2);
}

TEST_F(AssertionsDeathTest, FailureReportsConditionAndLocationAndAborts) {
    EXPECT_EXIT(need_positive(0), ::testing::KilledBySignal(SIGABRT),
                "^springdrive: assertion failed: value > 0, tests/base/assertions_test\\.cpp:" +
                    std::to_string(kLineOfNeed) + "\n$");
    EXPECT_DEATH(need_pair({2, 1}), "failed: pair == std::pair<int, int>\\{1, 2\\}, tests/");
    EXPECT_DEATH(static_cast<void>(half(3)), "failed: value % 2 == 0, ");
}

TEST_F(AssertionsDeathTest, AuditTierIsEvaluatedOnlyWhereEnabled) {
    int asked = 0;
    audit(asked, 1);
    EXPECT_EQ(asked, 1);
    EXPECT_DEATH(audit(asked, 0), "failed: \\+\\+asked > 0 && value > 0, tests/base/");
    leave_out(asked, 1);
    leave_out(asked, 0);
    EXPECT_EQ(asked, 1);
}

TEST(Assertions, NameFilesRelativeToTheProjectsRoot) {
    using assertions::path_in_project;
    static_assert(std::string_view(path_in_project("engine/servo/servo.cpp")) ==
                  "engine/servo/servo.cpp");
    static_assert(std::string_view(path_in_project(
                      "build/debug/rooms/contact/engine/contact/a.h")) == "engine/contact/a.h");
    static_assert(std::string_view(path_in_project("rooms/base/base/a.h")) == "base/a.h");
    static_assert(std::string_view(path_in_project("../../app/main.cpp")) == "app/main.cpp");
    static_assert(std::string_view(path_in_project("bedrooms/b/c.h")) == "bedrooms/b/c.h");
    static_assert(std::string_view(path_in_project("/rooms/of/build/rooms/base/base/a.h")) ==
                  "base/a.h");
}

TEST(RunGuarded, AbandonsFailingWorkAndReportsImmediately) {
    std::vector<std::string> told;
    told.reserve(4);
    AssertionFailure failure;
    const auto notify = [&](const AssertionFailure &what) {
        told.emplace_back("told");
        failure = what;
    };
    EXPECT_TRUE(run_guarded([&] { told.emplace_back("worked"); }, notify));
    EXPECT_FALSE(run_guarded(
        [&] {
            told.emplace_back("began");
            need_positive(-1); // noexcept: an exception could not leave it
            told.emplace_back("ended");
        },
        notify));
    EXPECT_EQ(told, (std::vector<std::string>{"worked", "began", "told"}));
    EXPECT_STREQ(failure.condition, "value > 0");
    EXPECT_STREQ(failure.file, "tests/base/assertions_test.cpp");
    EXPECT_EQ(failure.line, kLineOfNeed);
}

TEST(RunGuarded, CanBeNestedAndUsedAgain) {
    int inner = 0;
    int outer = 0;
    int rest = 0;
    for (int i = 0; i < 1000; ++i) {
        const bool whole = run_guarded(
            [&] {
                EXPECT_FALSE(run_guarded([] { need_positive(0); },
                                         [&](const AssertionFailure & /*failure*/) { ++inner; }));
                ++rest;
                need_positive(i % 2);
            },
            [&](const AssertionFailure & /*failure*/) { ++outer; });
        ASSERT_EQ(whole, i % 2 == 1);
    }
    EXPECT_EQ(inner, 1000);
    EXPECT_EQ(rest, 1000);
    EXPECT_EQ(outer, 500);
}

TEST_F(AssertionsDeathTest, AGuardCoversOnlyItsWorkAndThread) {
    const auto ignore_failure = [](const AssertionFailure & /*failure*/) {};
    ASSERT_FALSE(run_guarded([] { need_positive(0); }, ignore_failure));
    EXPECT_DEATH(need_positive(0), "value > 0");
    ASSERT_TRUE(run_guarded([] {}, ignore_failure));
    EXPECT_DEATH(need_positive(0), "value > 0");
    const auto on_another = [&] {
        static_cast<void>(
            run_guarded([] { std::thread([] { need_positive(0); }).join(); }, ignore_failure));
    };
    EXPECT_DEATH(on_another(), "value > 0");
}

TEST_F(AssertionsDeathTest, AFailureInsideTheHandlerEndsTheProgram) {
    const auto work = [] {
        static_cast<void>(run_guarded([] { need_positive(0); },
                                      [](const AssertionFailure &failure) {
                                          need_pair({failure.line, 0});
                                      }));
    };
    EXPECT_DEATH(work(), "failed: pair == ");
}

} // namespace
} // namespace springdrive
