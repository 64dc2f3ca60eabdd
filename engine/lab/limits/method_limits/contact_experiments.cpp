// Contact: a penalty method, which uses the closest point of a mesh, and the proxy.
#include "base/degrees.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/limits/method_limits/experiment_list.h"
#include "engine/lab/rig/closest_point.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

namespace springdrive::limits {

namespace {

constexpr const char *kClosest = "closest point (penalty)";
constexpr const char *kProxy = "proxy";
constexpr double kTickPeriod_s = 1e-3;
constexpr double kPlate_m = 2e-3;
constexpr double kHalf_m = 0.05; ///< of shapes without another size

/// A plate into which tips are pressed, its upper side at y = 0.
contact::TriangleSoup plate(double thickness_m) {
    return rig::solid_box({-kHalf_m, -thickness_m, -kHalf_m}, {kHalf_m, 0.0, kHalf_m});
}

std::string plate_text() { return "a plate of " + with_unit(1e3 * kPlate_m, "mm"); }

/// Away from the diagonals and the middles of faces.
const Vector3 kAside_m(0.01, 0.0, 0.02);

Vector3 at_height(double y_m) { return kAside_m + y_m * Vector3::UnitY(); }

/// Triangles are added with corners of their own.
void add(contact::TriangleSoup &soup, const std::array<Vector3, 3> &corners_m) {
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    soup.vertices_m.insert(soup.vertices_m.end(), corners_m.begin(), corners_m.end());
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.material_of_triangle.push_back(0);
}

void add_square(contact::TriangleSoup &soup, const std::array<Vector3, 4> &corners_m) {
    add(soup, {corners_m[0], corners_m[1], corners_m[2]});
    add(soup, {corners_m[0], corners_m[2], corners_m[3]});
}

/// Two level sheets beside each other at y = 0, `gap_m` apart, the gap along z through the origin.
contact::TriangleSoup cracked_sheet(double gap_m) {
    contact::TriangleSoup soup;
    soup.materials = {{"rigid"}};
    for (const double side : {-1.0, 1.0}) {
        const double near_m = 0.5 * side * gap_m;
        const double far_m = side * kHalf_m;
        add_square(soup,
                   {Vector3(near_m, 0.0, -side * kHalf_m), Vector3(near_m, 0.0, side * kHalf_m),
                    Vector3(far_m, 0.0, side * kHalf_m), Vector3(far_m, 0.0, -side * kHalf_m)});
    }
    return soup;
}

/// A pit, point down at the origin and open to +y.
/// @param faces        2 for a groove along z, 3 or more for as many triangles about the y axis
/// @param opening_rad  twice the angle between each face and the y axis
contact::TriangleSoup pit(int faces, double opening_rad) {
    contact::TriangleSoup soup;
    soup.materials = {{"rigid"}};
    const double out = std::sin(0.5 * opening_rad);
    const double up = std::cos(0.5 * opening_rad);
    if (faces == 2) {
        for (const double side : {-1.0, 1.0}) {
            const Vector3 rise = kHalf_m * Vector3(side * out, up, 0.0);
            const Vector3 along = kHalf_m * Vector3(0.0, 0.0, side);
            add_square(soup,
                       {Vector3(-along), along, Vector3(rise + along), Vector3(rise - along)});
        }
        return soup;
    }
    // The middle of each face rises at the opening's half angle; its corners reach farther out.
    const double turn_rad = 2.0 * std::numbers::pi / faces;
    const double reach = out / std::cos(0.5 * turn_rad);
    const auto rim = [&](int i) {
        const double angle = turn_rad * i;
        return Vector3(kHalf_m * Vector3(reach * std::sin(angle), up, reach * std::cos(angle)));
    };
    for (int i = 0; i < faces; ++i) {
        add(soup, {Vector3::Zero(), rim(i), rim(i + 1)});
    }
    return soup;
}

/// A tip pressed more than half way through a plate is nearer to the plate's other side.
Experiment closest_point_in_a_plate() {
    const auto finder = std::make_shared<rig::ClosestPointFinder>(plate(kPlate_m));
    return {{kClosest, "pressed in deeper than", "mm", plate_text(), 1e3 * 0.5 * kPlate_m},
            {1e3 * 1e-6, 1e3 * kPlate_m},
            [=](double depth_mm) {
                return finder->closest(at_height(-1e-3 * depth_mm)).normal.y() > 0.5;
            }};
}

/// The same holds for a tip so fast that it is already there in the first tick that finds it
/// inside.
Experiment closest_point_of_a_fast_tip() {
    constexpr int kPhases = 64;
    const auto finder = std::make_shared<rig::ClosestPointFinder>(plate(kPlate_m));
    const auto is_thrown_back = [finder](double start_m, double step_m) {
        for (double y_m = start_m; y_m > -2.0 * kHalf_m; y_m -= step_m) {
            const Vector3 tip_m = at_height(y_m);
            const rig::ClosestPoint found = finder->closest(tip_m);
            if (found.normal.dot(tip_m - found.point_m) < 0.0) {
                return found.normal.y() > 0.5;
            }
        }
        return false;
    };
    return {{kClosest, "tip faster than", "m/s",
             plate_text() + ", 1 kHz: expelled on the far side, at the worst phase of a tick",
             0.5 * kPlate_m / kTickPeriod_s},
            {0.1, 100.0},
            [=](double speed_m_per_s) {
                const double step_m = speed_m_per_s * kTickPeriod_s;
                for (int i = 0; i < kPhases; ++i) {
                    if (!is_thrown_back(1e-9 + step_m * i / kPhases, step_m)) {
                        return false;
                    }
                }
                return true;
            }};
}

/// Near the rim of a face the next face is nearer than the pressed one.
Experiment closest_point_near_an_edge() {
    constexpr double kDepth_m = 2e-3;
    const auto finder = std::make_shared<rig::ClosestPointFinder>(plate(kHalf_m));
    return {{kClosest, "nearer to a convex edge than", "mm",
             "pressed in by " + with_unit(1e3 * kDepth_m, "mm") + ": the force turns by 90°",
             1e3 * kDepth_m},
            {1e3 * kHalf_m / 2.0, 1e-3},
            [=](double distance_mm) {
                const Vector3 tip_m(kHalf_m - 1e-3 * distance_mm, -kDepth_m, kAside_m.z());
                return finder->closest(tip_m).normal.y() > 0.5;
            }};
}

/// Whether the proxy is still straight above a level surface at y = 0, within a tolerance that
/// exceeds the moves of vertex welding and is far below perception.
bool stands_above(const contact::Contact &contact, const Vector3 &tip_m) {
    constexpr double kOff_m = 1e-6;
    const Vector3 above(tip_m.x(), contact::kClearance_m, tip_m.z());
    return contact.touching && (contact.x0_m - above).norm() < kOff_m;
}

/// Whether the proxy stays on the surface while the tip moves straight through it from above.
bool is_held(const contact::HapticSurface &surface, double speed_m_per_s) {
    constexpr int kTicks = 50;
    contact::Proxy proxy;
    const double step_m = speed_m_per_s * kTickPeriod_s;
    proxy.reset(at_height(0.5 * step_m));
    Vector3 tip_m;
    contact::Contact contact;
    for (int i = 0; i < kTicks; ++i) {
        tip_m = at_height(0.5 * step_m - step_m * (i + 1));
        contact = proxy.update(surface, tip_m);
    }
    return stands_above(contact, tip_m);
}

Experiment proxy_of_a_fast_tip() {
    const auto surface = std::make_shared<contact::HapticSurface>(plate(kPlate_m));
    return {
        {kProxy, "tip faster than", "m/s", plate_text() + ", 1 kHz; tried from 1 mm/s to 1 km/s"},
        {1e-3, 1e3},
        [=](double speed_m_per_s) { return is_held(*surface, speed_m_per_s); }};
}

Experiment proxy_on_a_thin_plate() {
    constexpr double kSpeed_m_per_s = 2.0;
    return {{kProxy, "plate thinner than", "µm",
             "tip at " + with_unit(kSpeed_m_per_s, "m/s") + "; tried from 1 mm down to 1 nm"},
            {1e3, 1e-3},
            [=](double thickness_um) {
                return is_held(contact::HapticSurface(plate(1e-6 * thickness_um)), kSpeed_m_per_s);
            }};
}

Experiment proxy_on_a_crack() {
    return {{kProxy, "crack wider than", "µm",
             "two sheets beside each other, tip above the middle of the crack",
             1e6 * contact::kCrackTolerance_m},
            {0.1, 1e3},
            [](double width_um) {
                const contact::HapticSurface surface(cracked_sheet(1e-6 * width_um));
                contact::Proxy proxy;
                proxy.reset({0.0, 1e-3, kAside_m.z()});
                return proxy.update(surface, {0.0, -1e-3, kAside_m.z()}).touching;
            }};
}

/// A mesh with added triangles that are a line or a point.
contact::TriangleSoup with_degenerate(contact::TriangleSoup soup, double share) {
    const std::size_t sound = soup.triangles.size();
    const auto requested =
        static_cast<std::size_t>(std::lround(share / (1.0 - share) * static_cast<double>(sound)));
    soup.material_of_triangle.assign(sound, 0);
    soup.materials = {{"rigid"}};
    for (std::size_t i = 0; i < requested; ++i) {
        const auto [a, b, c] = soup.triangles[i % sound];
        const auto middle = static_cast<std::uint32_t>(soup.vertices_m.size());
        const Vector3 between_m = 0.5 * (soup.vertices_m[a] + soup.vertices_m[b]);
        soup.vertices_m.push_back(between_m);
        soup.triangles.push_back(i % 2 == 0 ? std::array{a, middle, b} : std::array{c, a, a});
        soup.material_of_triangle.push_back(0);
    }
    return soup;
}

Experiment proxy_on_degenerate_triangles() {
    constexpr int kDivisions = 2; // 320 triangles
    constexpr double kOff_m = 1e-12;
    const contact::TriangleSoup sphere = rig::icosphere(kDivisions, rig::kTestSphereRadius_m);
    return {{kProxy, "more degenerate triangles than", "%",
             "a sphere, same contact as without them; tried up to 90 % of all"},
            {0.1, 90.0},
            [=](double per_cent) {
                const contact::HapticSurface clean(with_degenerate(sphere, 0.0));
                const contact::HapticSurface faulty(with_degenerate(sphere, 1e-2 * per_cent));
                contact::Proxy on_clean;
                contact::Proxy on_faulty;
                on_clean.reset({0.0, 2.0 * rig::kTestSphereRadius_m, 0.0});
                on_faulty.reset({0.0, 2.0 * rig::kTestSphereRadius_m, 0.0});
                for (int i = 0; i < 1000; ++i) {
                    const double angle = 2.0 * std::numbers::pi * i / 1000.0;
                    const Vector3 tip_m =
                        0.98 * rig::kTestSphereRadius_m *
                        Vector3(std::sin(angle), std::cos(angle), 0.3).normalized();
                    const Vector3 apart_m =
                        on_clean.update(clean, tip_m).x0_m - on_faulty.update(faulty, tip_m).x0_m;
                    if (!(apart_m.norm() < kOff_m)) {
                        return false;
                    }
                }
                return true;
            }};
}

/// Pressed into the bottom of a pit, it rests at the clearance from all faces: kClearance over the
/// sine of the half opening above the edge or corner.
Experiment proxy_in_a_pit(const char *fails, int faces) {
    constexpr double kOff_m = 1e-9;
    return {{kProxy, fails, "°", "pressed in by 2 mm; tried from 179° to 1°"},
            {179.0, 1.0},
            [=](double opening_deg) {
                const double opening_rad = opening_deg * kRadiansPerDegree;
                const contact::HapticSurface surface(pit(faces, opening_rad));
                const double along_m = faces == 2 ? 0.01 : 0.0;
                contact::Proxy proxy;
                proxy.reset({0.0, 0.01, along_m});
                contact::Contact contact;
                for (int i = 1; i <= 100; ++i) { // slides down one face, then the other
                    const double swing_m = 1e-3 * std::sin(0.2 * i) * (100 - i) / 100.0;
                    contact = proxy.update(surface, {swing_m, 0.01 - 1.2e-4 * i, along_m});
                }
                const Vector3 bottom_m(0.0, contact::kClearance_m / std::sin(0.5 * opening_rad),
                                       along_m);
                return contact.settled && contact.active_constraints == faces &&
                       (contact.x0_m - bottom_m).norm() < kOff_m;
            }};
}

/// Free until it has left the plate, held from then on.
Experiment proxy_that_starts_inside() {
    const auto surface = std::make_shared<contact::HapticSurface>(plate(kHalf_m));
    return {{kProxy, "starts inside deeper than", "mm",
             "a plate of 50 mm: free until it has left, held from then on; tried to its middle"},
            {1e-3, 0.5e3 * kHalf_m},
            [=](double depth_mm) {
                constexpr int kTicks = 100;
                contact::Proxy proxy;
                const double depth_m = 1e-3 * depth_mm;
                proxy.reset(at_height(-depth_m));
                for (int i = 0; i < kTicks; ++i) {
                    const double y_m = depth_m * (2.0 * i / kTicks - 1.0);
                    if (proxy.update(*surface, at_height(y_m)).touching) {
                        return false;
                    }
                }
                const Vector3 tip_m = at_height(-depth_m);
                return stands_above(proxy.update(*surface, tip_m), tip_m);
            }};
}

} // namespace

Experiments contact_experiments() {
    return {closest_point_in_a_plate(),
            closest_point_of_a_fast_tip(),
            closest_point_near_an_edge(),
            proxy_on_a_thin_plate(),
            proxy_of_a_fast_tip(),
            proxy_in_a_pit("concave edge narrower than", 2),
            proxy_in_a_pit("concave corner narrower than", 3),
            proxy_on_a_crack(),
            proxy_on_degenerate_triangles(),
            proxy_that_starts_inside()};
}

} // namespace springdrive::limits
