// Covers app/panels/doctor_popup.cpp: where the window offers the doctor, and what it then shows.
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <linux/capability.h>
#include <sys/prctl.h>

#include <string>
#include <thread>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

bool shows_answer(const Report &report) { return report.shows("disk for records in"); }

/// Of this thread, and of the programs that it starts, also where they run as root.
void give_up_real_time() {
    prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0);
    prctl(PR_CAPBSET_DROP, CAP_IPC_LOCK, 0, 0, 0);
}

TEST(DoctorInTheWindow, IsOfferedBesideWhatWasRefusedAndGivesItsLine) {
    std::thread([] {
        give_up_real_time();
        ShownWindow window;
        window.wait_until_running();
        const Report before = window.look();
        if (!before.shows("no real-time priority")) {
            return; // an ordinary user to whom it is granted
        }
        const double ticks = before.column("tick");
        window.click("Servo/doctor…");
        const Report answer = window.wait_until(shows_answer, "the doctor's answer");
        EXPECT_TRUE(answer.shows("SCHED_FIFO 80 refused")) << answer.texts();
        EXPECT_NE(answer.find("real-time priority/copy"), nullptr) << answer.texts();
        EXPECT_GT(answer.column("tick"), ticks); // the servo went on
        EXPECT_EQ(answer.column("trip_cause"), 0.0);
        window.click("Doctor/close");
        window.wait_until([](const Report &report) { return !shows_answer(report); }, "closed");
    }).join();
}

TEST(DoctorInTheWindow, IsOfferedWhereNoBoardIsFound) {
    ShownWindow window;
    window.wait_until_running();
    window.click("Scene/Plant");
    window.click("Plant/device");
    if (window.look().find("Plant/device/doctor…") == nullptr) {
        GTEST_SKIP() << "there is a board on USB";
    }
    window.click("Plant/device/doctor…");
    const Report answer = window.wait_until(shows_answer, "the doctor's answer");
    EXPECT_TRUE(answer.shows("board on USB: none is connected")) << answer.texts();
    EXPECT_NE(answer.find("board on USB/copy"), nullptr) << answer.texts();
    window.person().key("Escape");
    window.wait_until([](const Report &report) { return !shows_answer(report); }, "closed");
}

} // namespace
} // namespace springdrive::app
