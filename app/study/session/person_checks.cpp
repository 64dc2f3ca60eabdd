#include "app/study/session/study_session.h"

#include "app/study/participant/answers.h"
#include "app/study/participant/participant_layout.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {

namespace {

constexpr const char *kWhere = "with a person";

/// Whether it is more along the normal than across it.
bool is_gesture_along(const std::string &key, const Vector3 &normal) {
    const auto gesture = std::ranges::find(gestures(), input_name(key), &Gesture::name);
    return gesture != gestures().end() &&
           std::abs(gesture->direction.dot(normal)) > std::numbers::sqrt2 / 2.0;
}

/// Of the first condition whose spot is left along a gesture.
std::optional<study::ProtocolFinding> gesture_error(const study::Protocol &protocol,
                                                    const study::StudySetting &setting) {
    if (protocol.responses.device != study::ResponseDevice::gesture ||
        protocol.stimulus == study::StimulusForm::stroke) {
        return std::nullopt;
    }
    for (std::size_t i = 0; i < setting.conditions.size(); ++i) {
        for (const std::string &key : protocol.responses.keys) {
            if (study::is_used(protocol, i) &&
                is_gesture_along(key, setting.conditions[i].spot.normal)) {
                return study::ProtocolFinding{
                    study::Severity::error, kWhere,
                    fmt::format("responses.keys has \"{}\", which is the way off the surface in "
                                "condition \"{}\"",
                                key, protocol.conditions[i].name),
                    "take gestures to its sides"};
            }
        }
    }
    return std::nullopt;
}

study::ProtocolFindings errors_for_persons(const study::Protocol &protocol,
                                           const study::StudySetting &setting) {
    study::ProtocolFindings errors;
    if (const std::string wrong = validate_answers(protocol.responses); !wrong.empty()) {
        errors.push_back({study::Severity::error, kWhere, wrong, ""});
    }
    if (std::optional<study::ProtocolFinding> error = gesture_error(protocol, setting)) {
        errors.push_back(*std::move(error));
    }
    const study::ParameterFacts *const variable =
        study::condition_parameter_named(protocol.variable.parameter);
    if (protocol.task.kind == study::TaskKind::adjustment && variable->gain == nullptr) {
        errors.push_back(
            {study::Severity::error, kWhere,
             fmt::format("variable.parameter is {}, which cannot be adjusted while it is felt",
                         variable->name),
             "adjust a gain, such as eta, or choose another task"});
    }
    return errors;
}

struct NamedPicture {
    std::string text; ///< its key in the protocol
    ParticipantPicture picture;
};

/// Those of which a protocol's texts make the longest.
std::vector<NamedPicture> pictures_of(const study::Protocol &protocol) {
    std::vector<NamedPicture> pictures(2);
    pictures[0].text = "texts.instructions";
    pictures[0].picture = instructions_of(protocol);
    pictures[1].text = "texts.question";
    pictures[1].picture.heading = protocol.texts.question;
    pictures[1].picture.text = protocol.texts.respond;
    pictures[1].picture.choices = choices_of(protocol);
    if (std::ranges::any_of(protocol.conditions, [](const study::Condition &condition) {
            return condition.scene != study::kNoScene;
        })) {
        pictures[1].picture.scene = SceneShown::scene;
    }
    for (const study::QuestionnaireItem &item : protocol.questionnaire) {
        pictures.push_back({"questions." + item.name, picture_of(item, protocol.texts)});
    }
    for (NamedPicture &one : pictures) {
        one.picture.footer = protocol.texts.stop_key;
        one.picture.progress = 0.0;
    }
    return pictures;
}

} // namespace

study::ProtocolFindings check_for_persons(const study::Protocol &protocol,
                                          const study::StudySetting &setting) {
    study::ProtocolFindings findings = errors_for_persons(protocol, setting);
    Letters letters;
    for (const NamedPicture &one : pictures_of(protocol)) {
        if (!is_readable(one.picture, letters)) {
            findings.push_back({study::Severity::warning, one.text,
                                "does not fit on a screen of 1280 × 720 in letters that can be "
                                "read from where a participant sits",
                                "shorten it, with texts.stop_key below it"});
        }
    }
    return findings;
}

std::string validate_for_participants(const study::Protocol &protocol,
                                      const study::StudySetting &setting) {
    const study::ProtocolFindings errors = errors_for_persons(protocol, setting);
    if (errors.empty()) {
        return {};
    }
    const study::ProtocolFinding &first = errors.front();
    return first.where + ": " + first.what + (first.remedy.empty() ? "" : "; " + first.remedy);
}

} // namespace springdrive::app::study_screen
