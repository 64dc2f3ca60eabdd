// The straight pieces along which a proxy moved in one tick.
#pragma once

#include "base/assertions.h"
#include "base/vector.h"

#include <array>
#include <cstddef>

namespace springdrive::contact {

/// From its start to its place of rest, with every corner. No piece crosses a surface; a straight
/// line from the first point to the last may, where the path bends around an edge.
class ProxyPath {
public:
    static constexpr std::size_t kCapacity = 128;

    void restart(const Vector3 &at_m) noexcept {
        points_m_[0] = at_m;
        size_ = 1;
    }

    /// @pre not full
    [[gnu::always_inline]] void add(const Vector3 &point_m) noexcept {
        SPRINGDRIVE_ASSERT(size_ < kCapacity);
        points_m_[size_++] = point_m;
    }

    /// Removes all but the first `count` points.
    void cut(std::size_t count) noexcept { size_ = count; }

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] const Vector3 &operator[](std::size_t i) const noexcept { return points_m_[i]; }
    [[nodiscard]] const Vector3 *begin() const noexcept { return points_m_.data(); }
    [[nodiscard]] const Vector3 *end() const noexcept { return points_m_.data() + size_; }

private:
    std::array<Vector3, kCapacity> points_m_;
    std::size_t size_ = 0;
};

} // namespace springdrive::contact
