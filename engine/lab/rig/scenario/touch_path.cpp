#include "engine/lab/rig/scenario/touch_path.h"

#include "base/assertions.h"
#include "engine/scene/scripted_touch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace springdrive::rig {

namespace {

/// Height of a tip in free space above the point that it is about to touch.
constexpr double kAbove_m = 2e-3;

/// Distance of neighbouring points of a curve over the surface.
constexpr double kSpacing_m = 0.5e-3;

/// A path ends after this many directions in a row without a surface.
constexpr int kMaxMisses = 2000;

class RandomDraws {
public:
    explicit RandomDraws(std::uint64_t seed) : random_(seed) {}

    double between(double lower, double upper) {
        return std::uniform_real_distribution<double>(lower, upper)(random_);
    }

    bool one_in(unsigned many) { return random_() % many == 0; }

    Vector3 within(const Eigen::AlignedBox3d &box) {
        const double x = between(box.min().x(), box.max().x());
        const double y = between(box.min().y(), box.max().y());
        const double z = between(box.min().z(), box.max().z());
        return {x, y, z};
    }

    /// A unit vector, uniform over the sphere.
    Vector3 direction() {
        const double z = between(-1.0, 1.0);
        const double angle_rad = between(0.0, 2.0 * std::numbers::pi);
        const double r = std::sqrt(1.0 - z * z);
        return {r * std::cos(angle_rad), r * std::sin(angle_rad), z};
    }

private:
    std::mt19937_64 random_;
};

/// Samples a path of straight lines: one tip every `step_m`, up to a requested number.
class PathSampler {
public:
    /// @pre step_m > 0
    PathSampler(double step_m, std::size_t tips) : step_m_(step_m), requested_(tips) {
        SPRINGDRIVE_ASSERT(step_m > 0.0);
        tips_m_.reserve(tips);
    }

    /// Continues at this point, at any distance, with a tip there.
    void jump_to(const Vector3 &point_m) {
        end_m_ = point_m;
        to_next_m_ = step_m_;
        if (!is_full()) {
            tips_m_.push_back(point_m);
        }
    }

    /// Continues straight to this point. The tips are equally spaced along the path, so that none
    /// need lie on a corner.
    void move_to(const Vector3 &point_m) {
        const Vector3 line_m = point_m - end_m_;
        const double length_m = line_m.norm();
        for (; to_next_m_ <= length_m && !is_full(); to_next_m_ += step_m_) {
            tips_m_.emplace_back(end_m_ + to_next_m_ / length_m * line_m);
        }
        to_next_m_ -= length_m;
        end_m_ = point_m;
    }

    [[nodiscard]] bool is_full() const { return tips_m_.size() >= requested_; }

    /// The tips, once; where the path was too short, the last is repeated.
    /// @pre there is at least one
    [[nodiscard]] std::vector<Vector3> finish() {
        SPRINGDRIVE_ASSERT(!tips_m_.empty());
        tips_m_.resize(requested_, Vector3(tips_m_.back()));
        return std::move(tips_m_);
    }

private:
    double step_m_;
    std::size_t requested_;
    std::vector<Vector3> tips_m_;
    Vector3 end_m_{Vector3::Zero()}; ///< of the path so far
    double to_next_m_ = 0.0;         ///< distance from there to the next tip
};

/// Jumps outside the box along the great circle from one direction to the other, by 60° at most.
void go_round(PathSampler &path, const scene::SurfaceProbe &probe, const Vector3 &from,
              const Vector3 &to) {
    const double angle_rad = std::acos(std::clamp(from.dot(to), -1.0, 1.0));
    const int chords = static_cast<int>(std::ceil(angle_rad / (std::numbers::pi / 3.0)));
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(from, to);
    for (int i = 1; i <= chords; ++i) {
        const double share = static_cast<double>(i) / chords;
        path.jump_to(probe.outside(Eigen::Quaterniond::Identity().slerp(share, turn) * from));
    }
}

void press(PathSampler &path, const scene::SurfaceProbe &probe, RandomDraws &draws,
           double depth_m) {
    const Eigen::AlignedBox3d &box = probe.box();
    Vector3 from = draws.direction();
    path.jump_to(probe.outside(from));
    for (int misses = 0; misses < kMaxMisses && !path.is_full();) {
        const Vector3 to = draws.direction();
        const Vector3 start_m = probe.outside(to);
        const Vector3 inward = (draws.within(box) - start_m).normalized();
        const std::optional<Vector3> touch_m = probe.first_touch(
            start_m, start_m + 2.0 * (start_m - probe.middle_m()).norm() * inward);
        if (!touch_m) {
            ++misses;
            continue;
        }
        misses = 0;
        go_round(path, probe, from, to);
        path.jump_to(*touch_m - kAbove_m * inward);
        path.move_to(*touch_m + depth_m * inward);
        path.move_to(*touch_m - kAbove_m * inward);
        path.jump_to(start_m);
        from = to;
    }
}

/// Slides under the surface, from one direction as seen from the middle of the box to the next.
template <typename NextDirection, typename Depth>
void slide_along(PathSampler &path, const scene::SurfaceProbe &probe,
                 NextDirection &&next_direction, Depth &&depth_m) {
    path.jump_to(probe.outside(next_direction()));
    bool has_entered = false;
    Vector3 last_touch_m = Vector3::Zero();
    for (int misses = 0; misses < kMaxMisses && !path.is_full();) {
        const Vector3 direction = next_direction();
        const std::optional<Vector3> touch_m = probe.touch_from(direction);
        if (!has_entered) {
            path.jump_to(probe.outside(direction));
        }
        if (!touch_m) {
            if (has_entered) {
                // Straight on, the tip would pass a hole and go on inside without contact.
                has_entered = false;
                path.jump_to(last_touch_m + kAbove_m * direction);
            }
            ++misses;
            continue;
        }
        misses = 0;
        last_touch_m = *touch_m;
        if (!has_entered) {
            has_entered = true;
            path.jump_to(*touch_m + kAbove_m * direction);
        }
        path.move_to(*touch_m - depth_m() * direction);
    }
}

/// The angle about the middle of the box by which neighbouring points of a curve differ.
double angular_spacing_rad(const scene::SurfaceProbe &probe) {
    return kSpacing_m / std::max(kSpacing_m, 0.5 * probe.box().diagonal().norm());
}

void slide(PathSampler &path, const scene::SurfaceProbe &probe, RandomDraws &draws,
           double depth_m) {
    const double step_rad = angular_spacing_rad(probe);
    Vector3 direction = draws.direction();
    Vector3 axis = direction.unitOrthogonal();
    double turned_rad = 0.0;
    slide_along(
        path, probe,
        [&] {
            direction = (Eigen::AngleAxisd(step_rad, axis) * direction).normalized();
            turned_rad += step_rad;
            if (turned_rad >= 2.0 * std::numbers::pi) { // another circle through the same place
                axis = Eigen::AngleAxisd(draws.between(0.5, 2.5), direction) * axis;
                turned_rad = 0.0;
            }
            return direction;
        },
        [&] { return depth_m; });
}

void lissajous(PathSampler &path, const scene::SurfaceProbe &probe, RandomDraws &draws,
               double depth_m) {
    const double step_rad = angular_spacing_rad(probe);
    // Incommensurable, so that the curve never repeats.
    const Vector3 rate(1.0, std::numbers::phi, std::numbers::sqrt3);
    const Vector3 phase_rad(0.0, draws.between(0.5, 1.0), draws.between(1.5, 2.5));
    double t = 0.0;
    slide_along(
        path, probe,
        [&] {
            const Vector3 v = (t * rate + phase_rad).array().sin();
            const Vector3 velocity = rate.array() * (t * rate + phase_rad).array().cos();
            // Steps of equal angle: shorter in t where the curve passes close to the middle.
            const double angular_rate = v.cross(velocity).norm() / v.squaredNorm();
            t += std::min(step_rad / angular_rate, step_rad);
            return Vector3((t * rate + phase_rad).array().sin().matrix().normalized());
        },
        [&] { return depth_m * (1.0 + std::sin(7.0 * t) / 3.0); });
}

std::vector<Vector3> rain(const scene::SurfaceProbe &probe, RandomDraws &draws,
                          const TouchPathOptions &options) {
    constexpr double kGravity_m_per_s2 = 9.81;
    constexpr double kRest_s = 0.02;
    const Eigen::AlignedBox3d &box = probe.box();
    const double top_m = box.max().y() + options.radius_m + 0.01;
    const double bottom_m = box.min().y() - options.radius_m - 0.01;
    std::vector<Vector3> tips_m;
    tips_m.reserve(options.steps);
    while (tips_m.size() < options.steps) {
        Vector3 start_m = draws.within(box);
        start_m.y() = top_m;
        const Vector3 end_m(start_m.x(), bottom_m, start_m.z());
        const std::optional<Vector3> touch_m = probe.first_touch(start_m, end_m);
        const double fall_m = top_m - (touch_m ? touch_m->y() - options.depth_m : bottom_m);
        const double fall_s = std::sqrt(2.0 * fall_m / kGravity_m_per_s2);
        const auto ticks = static_cast<int>((2.0 * fall_s + kRest_s) / options.period_s);
        for (int i = 0; i <= ticks && tips_m.size() < options.steps; ++i) {
            const double t = i * options.period_s;
            const double fallen_s =
                std::clamp(std::min(t, 2.0 * fall_s + kRest_s - t), 0.0, fall_s);
            tips_m.emplace_back(start_m.x(), top_m - 0.5 * kGravity_m_per_s2 * fallen_s * fallen_s,
                                start_m.z());
        }
    }
    return tips_m;
}

std::vector<Vector3> random_walk(const scene::SurfaceProbe &probe, RandomDraws &draws,
                                 const TouchPathOptions &options) {
    constexpr double kRoomPerBox = 1.2;        // edges of the room that the tip stays in
    constexpr unsigned kTicksPerJump = 1000;   // on average
    constexpr double kMaxHeadingChange = 0.05; // per tick
    const Vector3 half_m = 0.5 * kRoomPerBox * probe.box().diagonal();
    const Eigen::AlignedBox3d room(probe.middle_m() - half_m, probe.middle_m() + half_m);
    const double step_m = options.speed_m_per_s * options.period_s;
    std::vector<Vector3> tips_m{probe.outside(draws.direction())};
    Vector3 heading = (probe.middle_m() - tips_m.front()).normalized();
    while (tips_m.size() < options.steps) {
        heading = (heading + kMaxHeadingChange * draws.direction()).normalized();
        Vector3 tip_m = tips_m.back() + step_m * heading;
        if (draws.one_in(kTicksPerJump)) {
            tip_m = draws.within(room);
        } else if (!room.contains(tip_m)) {
            heading = (probe.middle_m() - tip_m).normalized();
        }
        tips_m.push_back(tip_m);
    }
    return tips_m;
}

} // namespace

std::optional<TouchPathKind> touch_path_named(std::string_view name) {
    const auto *const found = std::ranges::find(kTouchPathNames, name, &TouchPathName::name);
    return found == kTouchPathNames.end() ? std::nullopt : std::optional(found->kind);
}

std::vector<Vector3> touch_path(const contact::HapticSurface &surface,
                                const Eigen::AlignedBox3d &box, const TouchPathOptions &options) {
    const scene::SurfaceProbe probe(surface, box, options.radius_m);
    RandomDraws draws(options.seed);
    PathSampler path(options.speed_m_per_s * options.period_s, options.steps);
    switch (options.kind) {
    case TouchPathKind::press:
        press(path, probe, draws, options.depth_m);
        break;
    case TouchPathKind::slide:
        slide(path, probe, draws, options.depth_m);
        break;
    case TouchPathKind::lissajous:
        lissajous(path, probe, draws, options.depth_m);
        break;
    case TouchPathKind::rain:
        return rain(probe, draws, options);
    case TouchPathKind::random:
        return random_walk(probe, draws, options);
    }
    return path.finish();
}

} // namespace springdrive::rig
