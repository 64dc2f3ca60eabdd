// Covers app/doctor/child_answer.cpp: work that answers, crashes, throws, talks too much or never
// ends.
#include "app/doctor/child_answer.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace springdrive::app::doctor {
namespace {

using std::chrono::milliseconds;

std::optional<std::string> answer_of(const std::function<std::string()> &work,
                                     milliseconds patience = milliseconds(20'000)) {
    ChildAnswer child(work);
    return child.by(ChildAnswer::Clock::now() + patience);
}

TEST(ChildAnswer, ReturnsWhatTheWorkReturns) {
    EXPECT_EQ(answer_of([] { return std::string("yes"); }), "yes");
    EXPECT_EQ(answer_of([] { return std::string(); }), "");
    const std::string much(1'000'000, 'x'); // more than a pipe holds
    EXPECT_EQ(answer_of([&] { return much; }), much);
}

TEST(ChildAnswer, ACrashIsNoAnswer) {
    EXPECT_EQ(answer_of([]() -> std::string {
                  std::raise(SIGKILL);
                  return "no";
              }),
              std::nullopt);
    EXPECT_EQ(answer_of([]() -> std::string { _exit(0); }), std::nullopt);
    EXPECT_EQ(answer_of([]() -> std::string { throw std::runtime_error("no"); }), std::nullopt);
}

TEST(ChildAnswer, TimeIsUpForWorkThatNeverEndsAndIgnoresSignals) {
    const auto start = ChildAnswer::Clock::now();
    EXPECT_EQ(answer_of(
                  []() -> std::string {
                      std::signal(SIGTERM, SIG_IGN);
                      for (;;) {
                          pause();
                      }
                  },
                  milliseconds(100)),
              std::nullopt);
    EXPECT_LT(ChildAnswer::Clock::now() - start, milliseconds(5'000));
}

TEST(ChildAnswer, WhatDriversPrintIsNotSeen) {
    ::testing::internal::CaptureStdout();
    EXPECT_EQ(answer_of([] {
                  std::puts("libGL: something");
                  std::fflush(stdout);
                  return std::string(std::getchar() == EOF ? "no input" : "input");
              }),
              "no input");
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

} // namespace
} // namespace springdrive::app::doctor
