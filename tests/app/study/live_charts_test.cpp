// Covers app/study/experimenter/live_charts.cpp: what the experimenter sees of the
// answers so far.
#include "app/study/experimenter/study_window.h"

#include "app/widgets/widgets.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/files.h"
#include "tests/support/imgui_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <variant>

namespace springdrive::app::study_screen {
namespace {

class StudyLiveCharts : public testing::ImGuiFrame {
protected:
    StudyLiveCharts() {
        // Right above a level of 0.1, wrong below it.
        contents_ = testing::conducted(protocol_, [](const study::PlannedTrial &planned) {
            study::Trial result(planned);
            const bool is_felt = *planned.level > 0.1;
            result.response = study::Chosen{is_felt ? *planned.target : 3 - *planned.target};
            return result;
        });
    }

    /// Waits for it, as frames would.
    const study::SeriesResult *fitted(const std::string &participant, std::size_t condition) {
        fit_.request(contents_, participant, condition, study::DeviceKind::simulated);
        for (int i = 0; i < 6000 && fit_.latest() == nullptr; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return fit_.latest();
    }

    /// Texts and kinds of what is drawn of it.
    std::string drawn(const study::SeriesResult &result) {
        ui::report().begin(true);
        ImGui::SetNextWindowSize({900.0F, 400.0F});
        ImGui::Begin("charts");
        draw_live_charts(protocol_, result);
        ImGui::End();
        std::string all;
        for (const ShownItem &item : ui::report().items()) {
            all += item.id + " " + item.text + "\n";
        }
        return all;
    }

    study::Protocol protocol_ =
        study::read_protocol_file(testing::assets() / "protocols" / "stiffness.toml");
    study::StudyContents contents_;
    LiveFit fit_{protocol_};
};

TEST_F(StudyLiveCharts, ShowTheCourseAndTheFunctionOfThePresentCondition) {
    const study::SeriesResult *const result = fitted("P01", 1);
    ASSERT_NE(result, nullptr);
    const auto of_condition = std::ranges::count_if(contents_.trials, [&](const auto &trial) {
        return trial.condition == protocol_.conditions[1].name && study::counts(trial);
    });
    EXPECT_EQ(std::ssize(result->trace), of_condition);
    ASSERT_TRUE(result->fitted);
    // The step of the answers at 0.1 lies between the levels of the staircase about it.
    EXPECT_GT(result->fitted->threshold.median, 0.05);
    EXPECT_LT(result->fitted->threshold.median, 0.2);
    const std::string shown = drawn(*result);
    EXPECT_NE(shown.find("levels"), std::string::npos) << shown;
    EXPECT_NE(shown.find("function"), std::string::npos) << shown;
    EXPECT_NE(shown.find(ui::formatted("threshold {:.3g}", result->fitted->threshold.median)),
              std::string::npos)
        << shown;
}

TEST_F(StudyLiveCharts, AreEmptyForWhomNothingIsStored) {
    EXPECT_EQ(fit_.latest(), nullptr);
    fit_.request(contents_, "P02", 0, study::DeviceKind::simulated);
    EXPECT_EQ(fit_.latest(), nullptr);
    fit_.request(contents_, "P01", 0, study::DeviceKind::usb); // there is none on that device
    EXPECT_EQ(fit_.latest(), nullptr);
}

} // namespace
} // namespace springdrive::app::study_screen
