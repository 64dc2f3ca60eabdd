#include "app/panels/panels.h"

#include "app/doctor/checks.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"

#include <algorithm>

namespace springdrive::app {

namespace {

constexpr const char *kTitle = "Doctor";

const ImVec4 &ink_of(doctor::Verdict verdict) {
    switch (verdict) {
    case doctor::Verdict::ok:
        return kGood;
    case doctor::Verdict::warning:
        return kWarning;
    case doctor::Verdict::failure:
        return kDanger;
    case doctor::Verdict::not_applicable:
        break;
    }
    return kFaintInk;
}

/// What is wrong comes with its line, which can be copied.
void show_check(const doctor::Check &check) {
    const ui::Scope scope(check.title);
    ui::wrapped(ink_of(check.verdict), "{}: {}", check.title, check.found);
    ui::explain(check.matters);
    if (check.fix.empty()) {
        return;
    }
    if (ui::small_button("copy")) {
        ImGui::SetClipboardText(check.fix.c_str());
    }
    ImGui::SameLine();
    ui::wrapped(kInk, "{}", check.fix);
}

void show_checks(const std::vector<doctor::Check> &checks) {
    using doctor::Verdict;
    for (const Verdict verdict :
         {Verdict::failure, Verdict::warning, Verdict::ok, Verdict::not_applicable}) {
        for (const doctor::Check &check : checks) {
            if (check.verdict == verdict) {
                show_check(check);
            }
        }
    }
}

} // namespace

std::string name_of(const session::DeviceChoice &choice) {
    const std::string kind(factory::kDeviceKindNames.at(static_cast<std::size_t>(choice.kind)));
    const bool has_serial = choice.kind == factory::DeviceKind::usb && !choice.serial.empty();
    return has_serial ? kind + ":" + choice.serial : kind;
}

void DoctorPopup::offer(const std::string &device, double servo_hz) {
    if (ui::small_button("doctor…")) {
        ask(device, servo_hz);
    }
    ui::explain("what this computer allows and lacks, each with the line that mends it; the same\n"
                "as springdrive doctor");
}

void DoctorPopup::ask(const std::string &device, double servo_hz) {
    checks_.reset();
    error_.clear();
    opens_ = true;
    asking_.start(
        [device, servo_hz](BackgroundTalk &) { return doctor::ask_doctor(device, servo_hz); });
}

void DoctorPopup::draw() {
    if (opens_) {
        ImGui::OpenPopup(kTitle);
        opens_ = false;
    }
    error_ += error_text_of([&] {
        if (auto answer = asking_.take()) {
            checks_ = std::move(answer);
        }
    });
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5F * window.x, 0.5F * window.y}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(0.9F * window.x, 46.0F * ImGui::GetFontSize()),
                              std::min(0.8F * window.y, 30.0F * ImGui::GetFontSize())});
    if (!ImGui::BeginPopup(kTitle)) {
        return;
    }
    {
        const ui::Scope scope(kTitle);
        if (ui::small_button("close")) {
            ImGui::CloseCurrentPopup();
        }
        if (!error_.empty()) {
            ui::wrapped(kDanger, "{}", error_);
        } else if (checks_) {
            show_checks(*checks_);
        } else {
            ui::text(kFaintInk, "looking at this computer, which takes up to three seconds");
        }
    }
    ImGui::EndPopup();
}

} // namespace springdrive::app
