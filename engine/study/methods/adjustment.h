// The method of adjustment: a trial starts at a drawn level, which the participant changes; its
// result is the setting.
#pragma once

#include "engine/study/methods/random_key.h"
#include "engine/study/methods/scale.h"
#include "engine/study/methods/trial.h"

#include <optional>
#include <string>

namespace springdrive::study {

struct Adjustment {
    Scale scale = Scale::linear; ///< on which starts are drawn and settings are averaged
    double minimum_start = 0.0;  ///< starts are uniform on the scale between both
    double maximum_start = 1.0;
    double minimum_level = 0.0; ///< reach of the settings
    double maximum_level = 1.0;
    int settings = 10;

    friend bool operator==(const Adjustment &, const Adjustment &) = default;
};

inline constexpr auto kAdjustmentFields = std::to_array<Field<Adjustment>>({
    {"scale", choice_of<&Adjustment::scale>(kScaleNames), "on which starts are drawn"},
    {"minimum_level", &Adjustment::minimum_level, "a step beyond ends here", kTypedLevel},
    {"maximum_level", &Adjustment::maximum_level, "and here", kTypedLevel},
    {"minimum_start", &Adjustment::minimum_start, "starts are drawn from here", kTypedLevel},
    {"maximum_start", &Adjustment::maximum_start, "to here", kTypedLevel},
    {"settings", &Adjustment::settings, "how many are made", 1.0, 1000.0},
});

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Adjustment &method);

[[nodiscard]] inline int max_trials(const Adjustment &method) { return method.settings; }

/// The method while it runs; see MethodRun.
class AdjustmentRun {
public:
    AdjustmentRun(const Adjustment &method, RandomKey key) : method_(method), key_(key) {}

    [[nodiscard]] bool is_done() const { return settings_ >= method_.settings; }
    [[nodiscard]] std::optional<MethodTrial> next() const;
    void add(const PastMethodTrial &trial) { settings_ += trial.outcome.marked ? 0 : 1; }

private:
    Adjustment method_;
    RandomKey key_;
    int settings_ = 0;
};

} // namespace springdrive::study
