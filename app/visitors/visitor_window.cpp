#include "app/visitors/visitor_window.h"

#include "app/host/ending_signal.h"
#include "app/widgets/widgets.h"
#include "base/error_text.h"

#include <fmt/core.h>

#include <iostream>

namespace springdrive::app::visitors {

namespace {

using study_screen::InputSource;
using study_screen::ParticipantInput;
using study_screen::ParticipantPicture;
using study_screen::SittingFrame;
using study_screen::SittingState;

} // namespace

void VisitorWindow::show_scene(const scene::Scene &scene, const scene::TouchSpot &spot) {
    window_.show_scene(scene, spot, session_.description().workspace);
}

void VisitorWindow::obey_staff(const std::vector<ParticipantInput> &inputs) {
    for (const ParticipantInput &input : inputs) {
        if (input.source != InputSource::key) {
            continue;
        }
        if (!input.is_press) {
            held_keys_.erase(input.name);
            continue;
        }
        held_keys_.insert(input.name);
        if (!held_keys_.contains("ctrl") || !held_keys_.contains("alt")) {
            continue;
        }
        is_asked_to_end_ = is_asked_to_end_ || input.name == "q";
        if (input.name == "z") {
            if (const std::string error =
                    error_text_of([this] { session_.zero_device(Vector3::Zero()); });
                !error.empty()) {
                std::cerr << "springdrive: " << error << '\n';
            }
        }
    }
}

void VisitorWindow::report(const ParticipantPicture &picture, const SittingState &state) const {
    const study_screen::ParticipantLayout &layout = window_.layout();
    ui::enter_at(layout.heading.box, "visitor/heading", "text", picture.heading);
    ui::enter_at(layout.text.box, "visitor/text", "text", picture.text);
    ui::enter_at(layout.footer.box, "visitor/footer", "text", picture.footer);
    ui::enter_at(layout.curve.plot, "visitor/curve", "text",
                 picture.curve ? fmt::format("{} dots", picture.curve->dots.size()) : "");
    ui::enter_at(layout.scene, "visitor/step", "text",
                 std::string(study_screen::description(state.step)));
    for (std::size_t i = 0; i < layout.choices.size(); ++i) {
        ui::enter_at(layout.choices[i].card, fmt::format("visitor/choice {}", i + 1), "button",
                     picture.choices[i].text);
    }
}

SittingFrame VisitorWindow::show(const ParticipantPicture &picture, const SittingState &state) {
    window_.show(picture);
    report(picture, state);
    if (window_.take_emergency_stop()) {
        session_.emergency_stop();
    }
    SittingFrame frame{window_.take_inputs(session_.servo()), {}};
    obey_staff(frame.inputs);
    frame.orders.stops = is_asked_to_end_ || asked_to_end();
    return frame;
}

} // namespace springdrive::app::visitors
