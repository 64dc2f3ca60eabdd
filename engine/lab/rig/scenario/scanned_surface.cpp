#include "engine/lab/rig/scenario/scanned_surface.h"

#include "base/split_mix.h"
#include "engine/lab/rig/scenario/known_shapes.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <random>
#include <utility>

namespace springdrive::rig {

namespace {

/// Points on one circle to round-off are left as they are: u for coordinates up to 1, with some
/// margin, so that no edge is flipped back and forth.
constexpr double kRoundOff = 1e-15;

constexpr double kNoise_m = 20e-6;
constexpr std::array kNoiseLengths_m{8e-3, 2e-3, 0.5e-3, 0.125e-3};

/// Logarithm of the density of points, standard deviation, and how far apart its extremes are.
constexpr double kDensitySpread = 0.6;
constexpr std::array kDensityLengths_rad{1.2, 0.3};

constexpr double kRim_rad = 0.004;
constexpr std::array kRimLengths_rad{0.03, 0.01};

constexpr int kHoles = 20;
constexpr double kMinHole_rad = 0.004;
constexpr double kMaxHole_rad = 0.04;
constexpr double kUnderside_rad = 0.3;

constexpr std::size_t kTrianglesPerSliver = 200;
constexpr double kMinSliver = 1e-3;
constexpr double kMaxSliver = 0.1;

/// Draws that are the same with every standard library.
class ScanDraws {
public:
    explicit ScanDraws(std::uint64_t seed) : random_(seed) {}

    double below_one() { return split_mix::unit_share(random_()); }
    double between(double lower, double upper) { return lower + below_one() * (upper - lower); }

    double of_any_size(double lower, double upper) {
        return std::exp(between(std::log(lower), std::log(upper)));
    }

    Vector3 direction() {
        const double z = between(-1.0, 1.0);
        const double angle = between(0.0, 2.0 * std::numbers::pi);
        const double r = std::sqrt(1.0 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }

    std::size_t index(std::size_t count) { return random_() % count; }

private:
    std::mt19937_64 random_;
};

/// A smooth random function of space: plane waves in random directions at some wavelengths, all of
/// the same power.
class Waves {
public:
    template <std::size_t count>
    Waves(ScanDraws &draws, const std::array<double, count> &lengths, double rms)
        : amplitude_(rms * std::sqrt(2.0 / (count * kPerLength))) {
        for (const double length : lengths) {
            for (int i = 0; i < kPerLength; ++i) {
                const Vector3 direction = draws.direction();
                waves_.emplace_back(2.0 * std::numbers::pi / length * direction,
                                    draws.between(0.0, 2.0 * std::numbers::pi));
            }
        }
    }

    [[nodiscard]] double at(const Vector3 &place) const {
        double sum = 0.0;
        for (const auto &[wave_vector, phase] : waves_) {
            sum += std::sin(wave_vector.dot(place) + phase);
        }
        return amplitude_ * sum;
    }

private:
    static constexpr int kPerLength = 6;
    double amplitude_;
    std::vector<std::pair<Vector3, double>> waves_;
};

double angle_between(const Vector3 &a, const Vector3 &b) {
    return 2.0 * std::asin(std::min(1.0, 0.5 * (a - b).norm()));
}

/// Triangles between directions, the largest divided next.
class ScanPoints {
public:
    explicit ScanPoints(std::uint64_t seed)
        : holes_(scan_holes(seed)), draws_(seed + 1),
          density_(draws_, kDensityLengths_rad, kDensitySpread),
          rim_(draws_, kRimLengths_rad, kRim_rad) {
        for (std::uint32_t i = 0; i < mesh_.triangles().size(); ++i) {
            weigh(i);
        }
    }

    /// Until so many triangles are outside the holes.
    void grow(std::size_t triangles) {
        while (measured_ < triangles) {
            const auto [weight, number, version] = largest_.top();
            largest_.pop();
            if (version != known_[number].version) {
                continue;
            }
            const auto &[a, b, c] = mesh_.triangles()[number];
            double u = draws_.between(0.02, 0.98);
            double v = draws_.between(0.02, 0.98);
            if (u + v >= 1.0) {
                u = 1.0 - u;
                v = 1.0 - v;
            }
            const auto &points = mesh_.points();
            const Vector3 place = (1.0 - u - v) * points[a] + u * points[b] + v * points[c];
            for (const std::uint32_t changed : mesh_.insert(number, place.normalized())) {
                weigh(changed);
            }
        }
    }

    [[nodiscard]] const SphereTriangulation &mesh() const { return mesh_; }
    [[nodiscard]] bool is_measured(std::size_t triangle) const {
        return known_[triangle].is_measured;
    }

private:
    struct Known {
        std::uint32_t version = 0;
        bool is_measured = false;
    };
    struct Waiting {
        double weight;
        std::uint32_t triangle;
        std::uint32_t version;
        bool operator<(const Waiting &other) const { return weight < other.weight; }
    };

    [[nodiscard]] bool is_in_hole(const Vector3 &direction) const {
        return std::ranges::any_of(holes_, [&](const ScanHole &hole) {
            const double outside_rad =
                angle_between(direction, hole.direction) - hole.half_angle_rad;
            return outside_rad < kMaxRaggedness_rad && outside_rad < rim_.at(direction);
        });
    }

    void weigh(std::uint32_t triangle) {
        const auto &[a, b, c] = mesh_.triangles()[triangle];
        const auto &points = mesh_.points();
        const Vector3 middle = (points[a] + points[b] + points[c]).normalized();
        const double area = (points[b] - points[a]).cross(points[c] - points[a]).norm();
        known_.resize(mesh_.triangles().size());
        Known &known = known_[triangle];
        measured_ -= known.is_measured ? 1 : 0;
        known.is_measured = !is_in_hole(middle);
        measured_ += known.is_measured ? 1 : 0;
        largest_.push({area * std::exp(density_.at(middle)), triangle, ++known.version});
    }

    std::vector<ScanHole> holes_;
    ScanDraws draws_;
    Waves density_;
    Waves rim_;
    SphereTriangulation mesh_;
    std::vector<Known> known_;
    std::priority_queue<Waiting> largest_;
    std::size_t measured_ = 0;
};

/// The triangles outside the holes, and their points moved out to the body.
contact::TriangleSoup measured(const ScanPoints &scan, const Waves &noise_m) {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    contact::TriangleSoup soup;
    std::vector<std::uint32_t> vertex_of_point(scan.mesh().points().size(), kNone);
    for (std::size_t i = 0; i < scan.mesh().triangles().size(); ++i) {
        if (!scan.is_measured(i)) {
            continue;
        }
        SphereTriangulation::Triangle triangle = scan.mesh().triangles()[i];
        for (std::uint32_t &corner : triangle) {
            std::uint32_t &vertex = vertex_of_point[corner];
            if (vertex == kNone) {
                vertex = static_cast<std::uint32_t>(soup.vertices_m.size());
                const Vector3 &direction = scan.mesh().points()[corner];
                const double radius_m = scanned_body_radius_m(direction);
                soup.vertices_m.emplace_back((radius_m + noise_m.at(radius_m * direction)) *
                                             direction);
            }
            corner = vertex;
        }
        soup.triangles.push_back(triangle);
    }
    return soup;
}

/// Divides a triangle in three at a point close to its edge, off its plane by as much at most.
void add_sliver(contact::TriangleSoup &soup, ScanDraws &draws) {
    const std::size_t divided = draws.index(soup.triangles.size());
    const auto [a, b, c] = soup.triangles[divided];
    const Vector3 to_b = soup.vertices_m[b] - soup.vertices_m[a];
    const Vector3 to_c = soup.vertices_m[c] - soup.vertices_m[a];
    const double thinness = draws.of_any_size(kMinSliver, kMaxSliver);
    const double along = draws.between(0.1, 0.8);
    const double height_m = thinness * to_b.norm() * draws.between(-0.5, 0.5);
    const Vector3 place_m = soup.vertices_m[a] + along * to_b + thinness * to_c;
    const auto p = static_cast<std::uint32_t>(soup.vertices_m.size());
    soup.vertices_m.emplace_back((1.0 + height_m / place_m.norm()) * place_m);
    soup.triangles[divided] = {a, b, p};
    soup.triangles.insert(soup.triangles.end(), {{b, c, p}, {c, a, p}});
}

} // namespace

SphereTriangulation::SphereTriangulation()
    : points_{Vector3::UnitX(),  Vector3::UnitY(),  Vector3::UnitZ(),
              -Vector3::UnitX(), -Vector3::UnitY(), -Vector3::UnitZ()},
      triangles_{{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2},
                 {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}},
      neighbours_{{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                  {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}} {}

const std::vector<std::uint32_t> &SphereTriangulation::insert(std::uint32_t triangle,
                                                              const Vector3 &direction) {
    const auto p = static_cast<std::uint32_t>(points_.size());
    const auto second = static_cast<std::uint32_t>(triangles_.size());
    const std::uint32_t third = second + 1;
    const auto [a, b, c] = triangles_[triangle];
    const auto [across_bc, across_ca, across_ab] = neighbours_[triangle];
    points_.push_back(direction);
    triangles_[triangle] = {p, b, c};
    neighbours_[triangle] = {across_bc, second, third};
    triangles_.insert(triangles_.end(), {{p, c, a}, {p, a, b}});
    neighbours_.insert(neighbours_.end(),
                       {{across_ca, third, triangle}, {across_ab, triangle, second}});
    replace_neighbour(across_ca, triangle, second);
    replace_neighbour(across_ab, triangle, third);

    // Lawson's flips: only edges opposite to the new point can be wrong.
    unchecked_ = changed_ = {triangle, second, third};
    while (!unchecked_.empty()) {
        const std::uint32_t checked = unchecked_.back();
        unchecked_.pop_back();
        const std::uint32_t other = neighbours_[checked][0];
        const auto opposite = static_cast<std::size_t>(
            std::ranges::find(neighbours_[other], checked) - neighbours_[other].begin());
        if (is_within_circle(checked, triangles_[other][opposite])) {
            flip_first_edge(checked, other, opposite);
            unchecked_.insert(unchecked_.end(), {checked, other});
            changed_.push_back(other);
        }
    }
    return changed_;
}

void SphereTriangulation::replace_neighbour(std::uint32_t of, std::uint32_t old,
                                            std::uint32_t replacement) {
    std::ranges::replace(neighbours_[of], old, replacement);
}

/// On a sphere the circle is cut off by the triangle's plane.
bool SphereTriangulation::is_within_circle(std::uint32_t triangle, std::uint32_t point) const {
    const auto &[a, b, c] = triangles_[triangle];
    const Vector3 &from = points_[a];
    return (points_[b] - from).cross(points_[c] - from).dot(points_[point] - from) >
           kRoundOff * (points_[b] - from).norm() * (points_[c] - from).norm();
}

/// Two triangles (p, b, c) and (d, c, b) become (p, b, d) and (p, d, c).
void SphereTriangulation::flip_first_edge(std::uint32_t triangle, std::uint32_t other,
                                          std::size_t opposite) {
    const auto [p, b, c] = triangles_[triangle];
    const std::uint32_t d = triangles_[other][opposite];
    const std::uint32_t across_cp = neighbours_[triangle][1];
    const std::uint32_t across_pb = neighbours_[triangle][2];
    const std::uint32_t across_bd = neighbours_[other][(opposite + 1) % 3];
    const std::uint32_t across_dc = neighbours_[other][(opposite + 2) % 3];
    triangles_[triangle] = {p, b, d};
    neighbours_[triangle] = {across_bd, other, across_pb};
    triangles_[other] = {p, d, c};
    neighbours_[other] = {across_dc, across_cp, triangle};
    replace_neighbour(across_bd, other, triangle);
    replace_neighbour(across_cp, triangle, other);
}

std::vector<ScanHole> scan_holes(std::uint64_t seed) {
    ScanDraws draws(seed);
    std::vector<ScanHole> holes{{-Vector3::UnitY(), kUnderside_rad}};
    for (int i = 0; i < kHoles; ++i) {
        const Vector3 direction = draws.direction();
        holes.push_back({direction, draws.of_any_size(kMinHole_rad, kMaxHole_rad)});
    }
    return holes;
}

double scanned_body_radius_m(const Vector3 &direction) {
    return kTestOrganicScale_m * organic_shape().distance(direction);
}

contact::TriangleSoup scanned_surface(std::size_t triangles, std::uint64_t seed) {
    const std::size_t slivers = triangles / kTrianglesPerSliver;
    ScanPoints scan(seed);
    scan.grow(triangles - 2 * slivers);
    ScanDraws draws(seed + 2);
    const Waves noise_m(draws, kNoiseLengths_m, kNoise_m);
    contact::TriangleSoup soup = measured(scan, noise_m);
    for (std::size_t i = 0; i < slivers; ++i) {
        add_sliver(soup, draws);
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"scan", 0.0}};
    return soup;
}

} // namespace springdrive::rig
