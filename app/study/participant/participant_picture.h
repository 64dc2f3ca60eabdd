// All that a participant may see at one moment, as plain values. Nothing in it depends on a
// condition, a level or a response: what is drawn is a function of these values, of the scene and
// of the size in pixels alone.
#pragma once

#include "base/vector.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

/// Texts are UTF-8; a line feed begins a new paragraph.
struct AnswerChoice {
    std::string text; ///< what it means; may be empty if there is a key
    std::string key;  ///< the label of the key or button that gives it, see `shown_key`; or empty

    friend bool operator==(const AnswerChoice &, const AnswerChoice &) = default;
};

/// A psychometric function, as it is shown to the one who gave the answers.
struct OwnCurve {
    /// All answers at one level.
    struct Dot {
        double level = 0.0;
        double right_share = 0.0;
        int trials = 0;

        friend bool operator==(const Dot &, const Dot &) = default;
    };
    /// The fitted function at a level, with its 95 % band.
    struct Point {
        double level = 0.0;
        double right_share = 0.0;
        double low = 0.0;
        double high = 0.0;

        friend bool operator==(const Point &, const Point &) = default;
    };
    /// The level at the threshold, with its 95 % interval.
    struct Threshold {
        double level = 0.0;
        double low = 0.0;
        double high = 0.0;

        friend bool operator==(const Threshold &, const Threshold &) = default;
    };

    double lowest_level = 1.0; ///< that can be presented; > 0, as the axis is logarithmic
    double highest_level = 10.0;
    double guess = 0.5;        ///< share of right answers by chance
    std::vector<double> ticks; ///< levels that are named at the axis
    std::string level_label;
    std::string share_label;
    std::vector<Dot> dots;
    std::vector<Point> course; ///< by rising level; empty before there is a fit
    std::optional<Threshold> threshold;

    friend bool operator==(const OwnCurve &, const OwnCurve &) = default;
};

enum class SceneShown : std::uint8_t { nothing, scene };

struct ParticipantPicture {
    std::string heading;               ///< large, one or two lines: the question, "1", "2"
    std::string text;                  ///< instructions, a questionnaire's question
    std::vector<AnswerChoice> choices; ///< wide plates: in one row if they fit
    /// Shows the mouse's cursor, and a click on a plate is an answer; otherwise the cursor is
    /// hidden, and clicks are those of mouse buttons, wherever they are.
    bool choices_take_clicks = false;
    bool has_text_field = false;      ///< a free text is being typed
    std::string typed;                ///< in that field, with a cursor at its end
    std::string footer;               ///< small, at the bottom: how to stop the device
    std::optional<double> progress;   ///< 0 to 1: a thin bar at the very bottom, without numbers
    std::optional<double> left_share; ///< 0 to 1, of a break or a warm-up: a bar that empties
    std::string left_text;            ///< below that bar
    SceneShown scene = SceneShown::nothing;
    /// Centre of the ball; where the session says, which in contact is not where the tip is.
    std::optional<Vector3> tip_m;
    /// In place of a scene, at the end of a visitor's task; never in a study.
    std::optional<OwnCurve> curve;
    bool is_calm_stop = false; ///< the device stopped itself: the text is on a calm plate

    friend bool operator==(const ParticipantPicture &, const ParticipantPicture &) = default;
};

} // namespace springdrive::app::study_screen
