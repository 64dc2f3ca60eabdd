// Target path of a hand over time: a polyline through timed points.
#pragma once

#include "base/vector.h"
#include "device/core/hand_parameters.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace springdrive::simulated {

struct HandTarget {
    Vector3 position_m{Vector3::Zero()};
    Vector3 velocity_m_per_s{Vector3::Zero()};
};

/// Linear between its points; at rest before the first and after the last.
class HandPath {
public:
    using Point = device::PathPoint;

    /// @throw InputError unless there is a point, all are finite and their times increase.
    explicit HandPath(std::vector<Point> points);

    enum class Header : std::uint8_t { required, optional };

    /// Reads a CSV file with the header `t,x,y,z` [s, m].
    /// @throw InputError naming the file, the line and what is wrong with it.
    [[nodiscard]] static HandPath read_csv(const std::filesystem::path &file,
                                           Header header = Header::required);

    /// RT-safe. `time_s` must not decrease between calls.
    [[nodiscard]] HandTarget at(double time_s) noexcept;

    [[nodiscard]] const std::vector<Point> &points() const { return points_; }

    /// Time of the last point.
    [[nodiscard]] double end_s() const { return points_.back().time_s; }

private:
    std::vector<Point> points_;
    std::size_t next_ = 0; ///< the first point after the last requested time
};

} // namespace springdrive::simulated
