#include "engine/contact/proxy/haptic_surface.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/parallel.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

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

namespace {

/// Facets found near a place: collects indices only, before the facets themselves are read. Where
/// there are too many, the ball shrinks.
class FacetCandidates {
public:
    // Entries beyond size_ are never read. NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
    FacetCandidates(double radius_m, double min_radius_m, std::size_t capacity) noexcept
        : squared_radius_m2_(radius_m * radius_m),
          min_squared_radius_m2_(min_radius_m * min_radius_m), capacity_(capacity) {}

    void add(std::uint32_t index, double squared_distance_m2) noexcept {
        while (size_ == capacity_ && squared_distance_m2 <= squared_radius_m2_ && is_useful()) {
            squared_radius_m2_ *= 0.5;
            shrink();
        }
        if (squared_distance_m2 <= squared_radius_m2_ && size_ < capacity_) {
            found_[size_++] = {index, squared_distance_m2};
        }
    }

    /// Whether it is listed already; as near as its nearest part then.
    [[nodiscard]] bool comes_nearer(std::uint32_t index, double squared_distance_m2) noexcept {
        for (std::size_t i = 0; i < size_; ++i) {
            if (found_[i].index == index) {
                found_[i].squared_distance_m2 =
                    std::min(found_[i].squared_distance_m2, squared_distance_m2);
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] double squared_radius_m2() const noexcept { return squared_radius_m2_; }

    /// Whether the ball is large enough to be useful.
    [[nodiscard]] bool is_useful() const noexcept {
        return squared_radius_m2_ >= min_squared_radius_m2_;
    }

    template <typename Visit> void for_each(const Visit &visit) const noexcept {
        for (std::size_t i = 0; i < size_; ++i) {
            visit(found_[i].index);
        }
    }

private:
    struct Found {
        std::uint32_t index;
        double squared_distance_m2;
    };

    void shrink() noexcept {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            if (found_[i].squared_distance_m2 <= squared_radius_m2_) {
                found_[kept++] = found_[i];
            }
        }
        size_ = kept;
    }

    double squared_radius_m2_;
    double min_squared_radius_m2_;
    std::size_t capacity_;
    std::size_t size_ = 0;
    std::array<Found, Neighbourhood::kCapacity> found_;
};

/// Keeps the stop that comes first.
class FirstStop {
public:
    void consider(const std::optional<Stop> &stop, std::uint32_t obstacle) noexcept {
        if (stop && (!first_ || stop->fraction < first_->stop.fraction)) {
            first_ = SurfaceStop{*stop, obstacle, !stop->normal.isZero(0.0)};
        }
    }

    [[nodiscard]] double fraction() const noexcept { return first_ ? first_->stop.fraction : 1.0; }
    [[nodiscard]] const std::optional<SurfaceStop> &get() const noexcept { return first_; }

private:
    std::optional<SurfaceStop> first_;
};

template <typename Visit> void for_each(ShapeSet shapes, const Visit &visit) {
    for (; shapes != 0; shapes &= shapes - 1) {
        visit(static_cast<std::size_t>(std::countr_zero(shapes)));
    }
}

} // namespace

std::optional<SurfaceStop> HapticSurface::first_stop(const Vector3 &from_m, const Vector3 &to_m,
                                                     double reach_m,
                                                     SearchBudget &budget) const noexcept {
    FirstStop first;
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
        first.consider(stop_at_shape(i, from_m, to_m, reach_m, first.fraction()),
                       static_cast<std::uint32_t>(facets_.size() + i));
    }
    const double searched = tree_.along(
        from_m, to_m, reach_m, budget, [&](std::uint32_t item, double last_fraction) noexcept {
            const std::uint32_t index = facet_of(item);
            first.consider(
                facets_[index].stop(from_m, to_m, reach_m, first.fraction(), budget.effort_left),
                index);
            return std::min(last_fraction, first.fraction());
        });
    if (searched < first.fraction()) {
        SurfaceStop unknown;
        unknown.stop.fraction = searched;
        unknown.is_known = false;
        return unknown;
    }
    return first.get();
}

std::optional<SurfaceStop> HapticSurface::first_stop(const Neighbourhood &near,
                                                     const Vector3 &from_m, const Vector3 &to_m,
                                                     double reach_m,
                                                     SearchBudget &budget) const noexcept {
    FirstStop first;
    near.for_each_in_the_way(from_m, to_m, reach_m, [&](std::uint32_t index) noexcept {
        first.consider(
            facets_[index].stop(from_m, to_m, reach_m, first.fraction(), budget.effort_left),
            index);
    });
    for_each(near.shapes(), [&](std::size_t i) {
        first.consider(stop_at_shape(i, from_m, to_m, reach_m, first.fraction()),
                       static_cast<std::uint32_t>(facets_.size() + i));
    });
    return first.get();
}

std::optional<ShapeSlide> HapticSurface::slide_over(std::uint32_t obstacle,
                                                    const Neighbourhood &near,
                                                    const Vector3 &from_m, const Vector3 &tip_m,
                                                    double reach_m) const noexcept {
    if (obstacle < facets_.size()) {
        return std::nullopt;
    }
    SPRINGDRIVE_ASSERT(near.covers(from_m, reach_m));
    const ShapeSet own = ShapeSet{1} << (obstacle - facets_.size());
    std::optional<ShapeSlide> slide = slide_over_face(*shape(obstacle), from_m, tip_m, reach_m);
    if (!slide || (near.has_only(own) && near.covers(slide->over_m, reach_m) &&
                   near.covers(slide->rest_m, reach_m))) {
        return slide;
    }
    const ShapeSet others = near.shapes() & ~own;
    if (near.has_shallower(tip_m, slide->depth_m) ||
        !is_clear_of(others, near, from_m, slide->over_m, reach_m) ||
        (!slide->is_flat && !is_clear_of(others, near, slide->over_m, slide->rest_m, reach_m))) {
        slide.reset();
    }
    return slide;
}

bool HapticSurface::is_clear_of(ShapeSet shapes, const Neighbourhood &near, const Vector3 &from_m,
                                const Vector3 &to_m, double reach_m) const noexcept {
    bool is_clear = near.covers(to_m, reach_m);
    near.for_each_in_the_way(from_m, to_m, reach_m,
                             [&](std::uint32_t) noexcept { is_clear = false; });
    for_each(shapes, [&](std::size_t i) {
        is_clear = is_clear && shapes_[i].is_parted_from(from_m, to_m, reach_m - kSlack_m);
    });
    return is_clear;
}

void HapticSurface::find_near(const Vector3 &centre_m, double radius_m, SearchBudget &budget,
                              Neighbourhood &near, double min_radius_m) const noexcept {
    FacetCandidates found(radius_m, min_radius_m,
                          has_two_sided_ ? Neighbourhood::kCapacity / 2 : Neighbourhood::kCapacity);
    const bool is_complete = tree_.within(
        centre_m, radius_m, budget, [&](std::uint32_t item, double squared_distance_m2) noexcept {
            const std::uint32_t index = facet_of(item);
            budget.effort_left -= kFacetEffort;
            // Read when all are found: prefetched until then.
            const char *facet = reinterpret_cast<const char *>(&facets_[index]);
            __builtin_prefetch(facet);
            __builtin_prefetch(facet + 64);
            if (facet_of_item_.empty() || !found.comes_nearer(index, squared_distance_m2)) {
                found.add(index, squared_distance_m2);
            }
            return found.is_useful() ? found.squared_radius_m2() : -1.0;
        });
    near.begin(serial_, centre_m);
    if (!is_complete || !found.is_useful()) {
        return;
    }
    found.for_each([&](std::uint32_t index) noexcept { near.add(index, facets_[index]); });
    near.complete(std::sqrt(found.squared_radius_m2()));
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
        if (shapes_[i].nearest(centre_m).distance_m <= near.radius_m()) {
            near.add_shape(i);
        }
    }
}

std::optional<Stop> HapticSurface::stop_at_shape(std::size_t shape, const Vector3 &from_m,
                                                 const Vector3 &to_m, double reach_m,
                                                 double last_fraction) const noexcept {
    const NearestOnShape start = shapes_[shape].nearest(from_m);
    if (start.distance_m < 0.0) {
        return std::nullopt; // starts inside: it may leave
    }
    if (start.distance_m >= reach_m && start.normal.dot(to_m - start.point_m) >= reach_m) {
        return std::nullopt; // the plane between them separates it from the whole motion
    }
    return advance_to_touch(
        from_m, to_m, 0.0, start.point_m, reach_m, last_fraction,
        [&](const Vector3 &point_m) { return shapes_[shape].nearest(point_m).point_m; });
}

std::optional<Stop> HapticSurface::touch(std::uint32_t obstacle, const Vector3 &point_m,
                                         double reach_m, double within_m) const noexcept {
    if (obstacle < facets_.size()) {
        return facets_[obstacle].touch(point_m, reach_m, within_m);
    }
    const NearestOnShape nearest = shapes_[obstacle - facets_.size()].nearest(point_m);
    if (nearest.distance_m < 0.0 || nearest.distance_m > reach_m + within_m) {
        return std::nullopt;
    }
    return Stop{0.0, nearest.normal,
                nearest.normal.dot(nearest.point_m) + kept_distance_m(nearest.distance_m, reach_m)};
}

SurfacePoint HapticSurface::point_on_shape(std::uint32_t obstacle,
                                           const Vector3 &point_m) const noexcept {
    const std::size_t shape = obstacle - facets_.size();
    SurfacePoint found;
    found.point_m = point_m;
    found.triangle = static_cast<std::uint32_t>(report_.triangles_given + shape);
    found.material = shapes_[shape].material();
    return found;
}

SurfacePoint HapticSurface::nearest(std::uint32_t obstacle, const Vector3 &point_m) const noexcept {
    if (obstacle >= facets_.size()) {
        return point_on_shape(obstacle, shape(obstacle)->nearest(point_m).point_m);
    }
    SurfacePoint found;
    found.material = facets_[obstacle].material();
    const TrianglePoint nearest = facets_[obstacle].nearest(point_m);
    found.point_m = nearest.point_m;
    found.barycentric = nearest.weights;
    found.triangle = facets_[obstacle].triangle();
    return found;
}

std::uint16_t HapticSurface::material_index(std::uint32_t obstacle) const noexcept {
    return obstacle < facets_.size() ? facets_[obstacle].material()
                                     : shapes_[obstacle - facets_.size()].material();
}

std::size_t HapticSurface::bytes() const noexcept {
    return facets_.capacity() * sizeof(Facet) + tree_.bytes() +
           facet_of_item_.capacity() * sizeof(std::uint32_t) +
           shapes_.capacity() * sizeof(AnalyticShape) +
           materials_.capacity() * sizeof(SurfaceMaterial);
}

// What happens once to a surface, before it is queried.

namespace {

[[nodiscard]] std::uint64_t next_serial() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

} // namespace

HapticSurface::HapticSurface(TriangleSoup soup, std::vector<AnalyticShape> shapes)
    : shapes_(std::move(shapes)), serial_(next_serial()) {
    if (shapes_.size() > kMaxShapes) {
        throw std::invalid_argument("HapticSurface: too many shapes");
    }
    if (!std::ranges::all_of(shapes_, [&](const AnalyticShape &shape) {
            return shape.material() < soup.materials.size();
        })) {
        throw std::invalid_argument("HapticSurface: a shape lacks its material");
    }
    PreparedMesh prepared = prepare_mesh(soup);
    report_ = std::move(prepared.report);
    materials_ = std::move(soup.materials);
    const FacetBoxes boxes = boxes_of(prepared.facets);
    tree_ = BoxTree(boxes.boxes_m, all_processors());
    facets_.reserve(prepared.facets.size());
    const bool has_cut = boxes.boxes_m.size() > prepared.facets.size();
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> index_of(has_cut ? prepared.facets.size() : 0, kNone);
    facet_of_item_.reserve(has_cut ? boxes.boxes_m.size() : 0);
    for (const std::uint32_t box : tree_.take_order()) {
        stop_if_given_up(facets_.size());
        const std::uint32_t source = boxes.facet_of_box[box];
        if (has_cut) {
            const bool is_new = index_of[source] == kNone;
            index_of[source] =
                is_new ? static_cast<std::uint32_t>(facets_.size()) : index_of[source];
            facet_of_item_.push_back(index_of[source]);
            if (!is_new) {
                continue;
            }
        }
        facets_.emplace_back(prepared.facets[source]);
        has_two_sided_ = has_two_sided_ || facets_.back().sides() == FacetSides::two;
    }
}

} // namespace springdrive::contact
