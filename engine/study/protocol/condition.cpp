#include "engine/study/protocol/condition.h"

#include "base/degrees.h"
#include "engine/servo/servo.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive::study {

namespace {

static_assert(kConditionParameters[0].range.minimum == servo::kMinRate_hz &&
              kConditionParameters[0].range.maximum == servo::kMaxRate_hz);

std::vector<ParameterFacts> all_parameters() {
    std::vector<ParameterFacts> all;
    for (const control::Parameter &gain : control::kParameters) {
        all.push_back({gain.name, gain.unit, gain.minimum, gain.maximum, gain.default_value(),
                       gain.help, gain.value, nullptr});
    }
    for (const Field<Condition> &one : kConditionParameters) {
        all.push_back({one.name, one.unit, one.range.minimum, one.range.maximum,
                       one.number(Condition{}), one.help, nullptr,
                       std::get<double Condition::*>(one.member)});
    }
    return all;
}

} // namespace

bool operator==(const Condition &a, const Condition &b) {
    const bool same_spot =
        a.spot.has_value() == b.spot.has_value() &&
        (!a.spot || (a.spot->point_m == b.spot->point_m && a.spot->normal == b.spot->normal));
    return same_spot && a.name == b.name && a.scene == b.scene && a.hold == b.hold &&
           a.tuning == b.tuning &&
           std::ranges::all_of(kConditionParameters, [&](const Field<Condition> &one) {
               return one.number(a) == one.number(b);
           });
}

std::span<const ParameterFacts> condition_parameters() {
    static const std::vector<ParameterFacts> all = all_parameters();
    return all;
}

const ParameterFacts *condition_parameter_named(std::string_view name) {
    const std::span<const ParameterFacts> all = condition_parameters();
    const auto found = std::ranges::find(all, name, &ParameterFacts::name);
    return found == all.end() ? nullptr : &*found;
}

Vector3 turn_axis(const Vector3 &normal, double turn_axis_deg) {
    const double kNearly = std::cos(1.0 * kRadiansPerDegree);
    const Vector3 from = std::abs(normal.x()) < kNearly ? Vector3::UnitX() : Vector3::UnitZ();
    const Vector3 at_zero = (from - from.dot(normal) * normal).normalized();
    return Eigen::AngleAxisd(turn_axis_deg * kRadiansPerDegree, normal) * at_zero;
}

Vector3 turned(const Condition &condition, const Vector3 &normal) {
    return Eigen::AngleAxisd(condition.turn_deg * kRadiansPerDegree,
                             turn_axis(normal, condition.turn_axis_deg)) *
           normal;
}

} // namespace springdrive::study
