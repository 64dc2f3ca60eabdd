// Somebody who goes through the assistant without a window, on an emulated device in lockstep.
#pragma once

#include "app/assistant/assistant.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::testing {

class Walker {
public:
    static constexpr const char *kByHand = "let the simulated hand do it";

    static session::SessionOptions options_with(const std::vector<std::string> &faults) {
        session::SessionOptions options;
        options.scene = assets() / "scenes/organic.gltf";
        options.device.file = assets() / "devices/phantom_1_0.toml";
        options.device.kind = factory::DeviceKind::emulated;
        options.lockstep = true;
        options.program_version = "of a test";
        for (const std::string &fault : faults) {
            options.emulation.faults.push_back(device::parse_fault(fault));
        }
        return options;
    }

    explicit Walker(const std::vector<std::string> &faults = {},
                    const std::filesystem::path &folder = {})
        : Walker(folder, options_with(faults)) {}
    Walker(const std::filesystem::path &folder, const session::SessionOptions &options)
        : session(options), assistant(folder) {
        if (options.starts_at_zero) {
            session.start(); // zeroed before the assistant looks
            assistant.update(session);
        } else {
            assistant.update(session);
            session.start();
        }
    }
    ~Walker() { session.stop(); }
    Walker(const Walker &) = delete;
    Walker &operator=(const Walker &) = delete;

    [[nodiscard]] app::assistant::StepReport report() const { return assistant.report(session); }
    [[nodiscard]] app::assistant::Verdict verdict() const { return report().verdict; }

    /// All that is said of the present step.
    [[nodiscard]] std::string text() const {
        const app::assistant::StepReport now = report();
        std::string all = now.to_do;
        for (const std::string &line : now.seen) {
            all += '\n' + line;
        }
        for (const app::assistant::Trouble &trouble : now.troubles) {
            all += '\n' + trouble.what + '\n' + trouble.remedy;
        }
        return all;
    }
    [[nodiscard]] bool says(const std::string &part) const {
        return text().find(part) != std::string::npos;
    }

    void run(double seconds) {
        static_cast<void>(run_until([] { return false; }, seconds));
    }
    bool run_until(const std::function<bool()> &is_so, double at_most_s) {
        constexpr double kFrame_s = 1.0 / 60.0;
        for (double passed_s = 0.0; passed_s < at_most_s && !is_so(); passed_s += kFrame_s) {
            session.advance(kFrame_s);
            assistant.update(session);
            while (session.scenes().is_loading()) {
                session.advance(0.0);
            }
        }
        return is_so();
    }

    [[nodiscard]] bool offers(const std::string &label) const {
        for (const app::assistant::Offer &offer : report().offers) {
            if (offer.label == label) {
                return offer.is_enabled;
            }
        }
        return false;
    }
    void choose(const std::string &label) {
        ASSERT_TRUE(run_until([&] { return offers(label); }, 5.0)) << label << '\n' << text();
        for (const app::assistant::Offer &offer : report().offers) {
            if (offer.label == label) {
                offer.choose();
                return;
            }
        }
    }
    /// As soon as it is possible.
    void next() {
        const app::assistant::StepName step = assistant.present();
        ASSERT_TRUE(run_until([&] { return assistant.can_go_on(session); }, 10.0)) << text();
        assistant.next(session);
        ASSERT_TRUE(!assistant.is_open() || assistant.present() != step);
    }

    // Whole steps, up to their verdict:

    void move_joints() {
        for (int joint = 0; joint < 3; ++joint) {
            choose(kByHand);
            run_until([&] { return !session.hand().follows_path(); }, 10.0);
            choose("yes, the same way");
        }
    }
    void zero() {
        choose(kByHand);
        run_until([&] { return !session.hand().follows_path(); }, 10.0);
        run(1.0);
        choose("zero here");
    }
    void test() {
        choose("start");
        run_until([&] { return !session.is_in_exclusive_use(); }, 90.0);
        run(0.1);
    }
    void touch() {
        choose(kByHand);
        run_until([&] { return verdict() == app::assistant::Verdict::good; }, 15.0);
    }

    /// Until the motion by hand has begun.
    void begin_calibration() {
        choose("start");
        ASSERT_TRUE(run_until([&] { return offers("that is enough"); }, 15.0)) << text();
    }
    void calibrate() {
        begin_calibration();
        ASSERT_TRUE(run_until([&] { return !session.is_in_exclusive_use(); }, 60.0)) << text();
        run(0.2);
    }

    /// Up to a step, with each one before done, or skipped.
    void walk_to(app::assistant::StepName step) {
        using app::assistant::StepName;
        while (assistant.is_open() && assistant.present() != step &&
               !::testing::Test::HasFailure()) {
            switch (assistant.present()) {
            case StepName::motion:
                move_joints();
                break;
            case StepName::zeroing:
                zero();
                break;
            case StepName::self_test:
                test();
                break;
            case StepName::touch:
                touch();
                break;
            case StepName::calibration:
                choose("skip");
                break;
            case StepName::link:
            case StepName::identity:
                break;
            }
            next();
        }
    }

    session::Session session;
    app::assistant::Assistant assistant;
};

} // namespace springdrive::testing
