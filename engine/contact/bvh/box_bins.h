// Boxes counted by where their centres lie, in equal bins along all three axes at once.
#pragma once

#include "engine/contact/bvh/box_split.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace springdrive::contact {

inline constexpr int kMostBoxBins = 16;

struct BoxBin {
    Bounds bounds;
    std::uint32_t count = 0;

    void add(const BoxBin &other) noexcept {
        bounds.extend(other.bounds);
        count += other.count;
    }
};

/// Which bin a centre falls into.
class BoxBinning {
public:
    /// @param count  of boxes: few do not need many bins
    BoxBinning(const Bounds &twice_centres, std::uint32_t count) noexcept
        : bins_(count < 32 ? kMostBoxBins / 2 : kMostBoxBins), lower_(twice_centres.lower) {
        const Float4 size = twice_centres.upper - twice_centres.lower;
        for (int axis = 0; axis < 3; ++axis) {
            // All in the first bin where there is nothing to tell them apart.
            bins_per_unit_[axis] =
                size[axis] > 1e-30F ? static_cast<float>(bins_) / size[axis] : 0.0F;
        }
    }

    [[nodiscard]] int bins() const noexcept { return bins_; }

    /// For x, y and z. Within the range of bins whatever the centre, so round-off does no harm.
    [[nodiscard]] Mask4 bins_of(Float4 twice_centre) const noexcept {
        const Float4 place = (twice_centre - lower_) * bins_per_unit_;
        const Float4 last = all_lanes(static_cast<float>(bins_ - 1));
        return __builtin_convertvector(larger(smaller(place, last), Float4{}), Mask4);
    }

private:
    int bins_;
    Float4 lower_;
    Float4 bins_per_unit_{};
};

class BoxBins {
public:
    explicit BoxBins(int bins) noexcept {
        for (auto &axis : bins_) {
            std::fill_n(axis.begin(), bins, BoxBin{});
        }
    }

    void add(const Bounds &bounds, Mask4 bins) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            bins_[axis][static_cast<std::size_t>(bins[axis])].add({bounds, 1});
        }
    }

    [[nodiscard]] const BoxBin &at(int axis, int bin) const noexcept {
        return bins_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(bin)];
    }

private:
    std::array<std::array<BoxBin, kMostBoxBins>, 3> bins_;
};

} // namespace springdrive::contact
