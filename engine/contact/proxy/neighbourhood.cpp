#include "engine/contact/proxy/neighbourhood.h"

#include "base/assertions.h"

#include <algorithm>
#include <cmath>

namespace springdrive::contact {

void Neighbourhood::add(std::uint32_t index, const Facet &facet) noexcept {
    SPRINGDRIVE_ASSERT(size_ + (facet.sides() == FacetSides::two ? 2 : 1) <= kCapacity);
    add_side(index, 1.0, facet);
    if (facet.sides() == FacetSides::two) {
        add_side(index, -1.0, facet);
    }
}

void Neighbourhood::add_side(std::uint32_t index, double side, const Facet &facet) noexcept {
    const int lane = size_ % kAtOnce;
    const auto row = static_cast<std::size_t>(size_ / kAtOnce);
    Planes &planes = planes_[row];
    planes.normal_x[lane] = side * facet.normal().x();
    planes.normal_y[lane] = side * facet.normal().y();
    planes.normal_z[lane] = side * facet.normal().z();
    planes.offset_m[lane] = side * facet.offset_m();
    index_[row][static_cast<std::size_t>(lane)] = index;
    ++size_;
}

void Neighbourhood::complete(double radius_m) noexcept {
    radius_m_ = radius_m;
    for (int i = size_; i % kAtOnce != 0; ++i) {
        Planes &planes = planes_[static_cast<std::size_t>(i / kAtOnce)];
        const int lane = i % kAtOnce;
        planes.normal_x[lane] = planes.normal_y[lane] = planes.normal_z[lane] = 0.0;
        planes.offset_m[lane] = -1.0; // every point is a metre above its plane
    }
}

double Neighbourhood::covered_fraction(const Vector3 &from_m, const Vector3 &to_m,
                                       double margin_m) const noexcept {
    if (covers(to_m, margin_m)) {
        return 1.0;
    }
    // Where |from + s motion − centre| = radius − margin, the later solution.
    const Vector3 start = from_m - centre_m_;
    const Vector3 motion = to_m - from_m;
    const double left_m = radius_m_ - margin_m;
    const double a = motion.squaredNorm();
    const double b = start.dot(motion);
    const double c = start.squaredNorm() - left_m * left_m;
    const double root = std::sqrt(std::max(0.0, b * b - a * c));
    return a > 0.0 ? std::clamp((root - b) / a, 0.0, 1.0) : 1.0;
}

} // namespace springdrive::contact
