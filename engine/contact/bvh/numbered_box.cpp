#include "engine/contact/bvh/numbered_box.h"

#include "base/assertions.h"
#include "base/vector.h"

#include <bit>
#include <cmath>

namespace springdrive::contact {

namespace {

/// Numbers are kept as floats that are never computed with: from here up to 2^30 more their bits
/// are those of ordinary floats, which no processor is slow with.
constexpr std::uint32_t kNumberOffset = 0x3F800000U;

/// The nearest float, or if that lies above, one of the next two below.
[[nodiscard]] float rounded_down(double value) noexcept {
    const auto nearest = static_cast<float>(value);
    const float step = std::abs(nearest) * 0x1p-23F + std::numeric_limits<float>::min();
    return double{nearest} > value ? nearest - step : nearest;
}

[[nodiscard]] float rounded_up(double value) noexcept { return -rounded_down(-value); }

} // namespace

NumberedBox::NumberedBox(const Eigen::AlignedBox3d &box, std::uint32_t number) noexcept {
    SPRINGDRIVE_ASSERT(number < std::uint32_t{1} << 30U);
    const Vector3 &lower = box.min();
    const Vector3 &upper = box.max();
    bounds_.lower = Float4{rounded_down(lower.x()), rounded_down(lower.y()),
                           rounded_down(lower.z()), std::bit_cast<float>(number + kNumberOffset)};
    bounds_.upper =
        Float4{rounded_up(upper.x()), rounded_up(upper.y()), rounded_up(upper.z()), 0.0F};
}

std::uint32_t NumberedBox::number() const noexcept {
    return std::bit_cast<std::uint32_t>(static_cast<float>(bounds_.lower[3])) - kNumberOffset;
}

} // namespace springdrive::contact
