// A whole session on the simulated device, in lockstep, with a participant and an experimenter that
// are made up; the study is in a folder of its own.
#pragma once

#include "app/study/sitting/sitting.h"
#include "device/core/faults.h"
#include "engine/study/protocol/protocol_file.h"
#include "tests/app/study/headless_study.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {

/// A frame of a session, before anybody acts in it.
struct Moment {
    MadeUpPort &port;
    session::Session &session;
    const ParticipantPicture &picture;
    const SittingState &state;
    bool is_new_step; ///< not that of the frame before
};
using EachFrame = std::function<void(const Moment &)>;

/// Of force directions, in one block.
class StudySitting : public ::testing::Test {
protected:
    StudySitting() {
        protocol_.blocks.resize(1);
        begin_study("sitting");
    }

    void begin_study(const std::string &name) {
        folder_ = testing::fresh_folder(name);
        study::create_study(file(), {protocol_.title, "text", "0.1.0"}, study::utc_now());
        study::StudyStore(file()).add({"P01", 1, study::utc_now()});
    }

    [[nodiscard]] std::filesystem::path file() const { return folder_ / "a.study"; }

    [[nodiscard]] session::SessionOptions options() const {
        session::SessionOptions options;
        const study::Condition &first = protocol_.conditions.front();
        options.scene = first.scene == study::kNoScene ? testing::assets() / "scenes" / "plate.gltf"
                                                       : study::scene_file_of(first, folders_);
        options.device.file = study::device_file_of(protocol_, folders_);
        options.device.kind = kind_;
        for (const std::string &fault : faults_) {
            options.emulation.faults.push_back(device::parse_fault(fault));
        }
        options.starts_at_zero = starts_at_zero_;
        options.lockstep = true;
        return options;
    }

    [[nodiscard]] SittingPlan plan() const {
        return {protocol_,      study::study_setting(protocol_, folders_),
                folders_,       "P01",
                keeps_records_, plays_noise_};
    }

    study::SessionEnding run(const EachFrame &each_frame = {}) {
        study::StudyStore store(file());
        session::Session session(options());
        MadeUpPort port(session, protocol_);
        std::optional<SittingStep> before;
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            const bool is_new_step = std::exchange(before, state.step) != state.step;
            if (each_frame) {
                each_frame({port, session, picture, state, is_new_step});
            }
        };
        session.start();
        Sitting sitting(store, plan(), session, port.scene_shower());
        show_to_end(sitting, port);
        steps_ = port.steps;
        return sitting.ending();
    }

    [[nodiscard]] study::StudyContents contents() const { return study::read_study(file()); }

    /// The same decisions without screens and without a device.
    [[nodiscard]] std::vector<study::Trial> headless() const {
        const auto present = [this](const study::PlannedTrial &planned) {
            study::Trial result(planned);
            const Decision decision = decision_of(planned);
            if (decision.after_s >= 0.0) {
                result.response = response_of(protocol_.task, decision.key);
            }
            return result;
        };
        return testing::conducted(protocol_, present).trials;
    }

    bool plays_noise_ = false;
    bool keeps_records_ = false;
    factory::DeviceKind kind_ = factory::DeviceKind::simulated;
    bool starts_at_zero_ = true;
    std::vector<std::string> faults_; ///< of an emulated board
    std::filesystem::path folder_;
    study::Protocol protocol_ = short_protocol("direction");
    study::ProtocolFolders folders_{testing::assets() / "protocols", testing::assets()};
    std::set<SittingStep> steps_; ///< of the last session
};

inline void expect_same_decisions(const std::vector<study::Trial> &seen,
                                  const std::vector<study::Trial> &wanted) {
    ASSERT_EQ(seen.size(), wanted.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
        testing::expect_same_decision(seen[i], wanted[i]);
    }
}

/// Once, in the midst of the first presentation of the trial at that place.
class Once {
public:
    explicit Once(int position) : position_(position) {}

    [[nodiscard]] bool is_now(const SittingState &state) {
        const bool is_meant = !is_done_ && state.step == SittingStep::interval &&
                              state.phase == study::StimulusPhase::presenting && state.trial &&
                              state.trial->place.block == 1 &&
                              state.trial->place.position == position_;
        is_done_ = is_done_ || is_meant;
        return is_meant;
    }

private:
    int position_;
    bool is_done_ = false;
};

} // namespace springdrive::app::study_screen
