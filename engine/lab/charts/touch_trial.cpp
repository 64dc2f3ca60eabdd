#include "engine/lab/charts/touch_trial.h"

#include "base/degrees.h"
#include "engine/lab/rig/scenario/blob_shape.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/curved_patches.h"
#include "engine/scene/smooth_nodes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace springdrive::charts {

namespace {

constexpr std::size_t kMaxCuts = 128;

using Corners = std::array<Vector3, 3>;

/// The twelve triangles of a box about the origin, wound outwards.
std::vector<Corners> box_triangles(const Vector3 &half_size_m) {
    std::vector<Corners> triangles;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const Vector3 out = side * Vector3::Unit(axis);
            const Vector3 u = Vector3::Unit((axis + 1) % 3);
            const Vector3 v = out.cross(u); // u, v, out are right-handed
            const auto corner = [&](double a, double b) {
                return Vector3(half_size_m.cwiseProduct(out + a * u + b * v));
            };
            triangles.push_back({corner(-1, -1), corner(1, -1), corner(1, 1)});
            triangles.push_back({corner(-1, -1), corner(1, 1), corner(-1, 1)});
        }
    }
    return triangles;
}

std::vector<Corners> divided(const std::vector<Corners> &coarse) {
    std::vector<Corners> fine;
    fine.reserve(4 * coarse.size());
    for (const auto &[a, b, c] : coarse) {
        const Vector3 ab = 0.5 * (a + b);
        const Vector3 bc = 0.5 * (b + c);
        const Vector3 ca = 0.5 * (c + a);
        fine.insert(fine.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    return fine;
}

/// Vertices are not shared; mesh preparation welds them.
contact::TriangleSoup plate_mesh(int divisions) {
    std::vector<Corners> triangles = box_triangles(rig::thin_plate_half_size_m());
    for (int i = 0; i < divisions; ++i) {
        triangles = divided(triangles);
    }
    contact::TriangleSoup soup;
    for (const Corners &corners : triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
        soup.vertices_m.insert(soup.vertices_m.end(), corners.begin(), corners.end());
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"plate", 0.0}};
    return soup;
}

contact::AnalyticShape about_origin(const contact::AnalyticShape::Size &size) {
    return {size, Eigen::Isometry3d::Identity(), 0};
}

} // namespace

TouchTrial sphere_trial(std::size_t tips) {
    return {"a sphere of 50 mm radius", rig::tips_in_sphere(tips),
            [](int divisions) { return rig::icosphere(divisions, rig::kTestSphereRadius_m); },
            [](const Vector3 &vertex_m) { return vertex_m.normalized(); },
            about_origin(contact::Sphere{rig::kTestSphereRadius_m})};
}

TouchTrial organic_trial(std::size_t tips) {
    return {"an organic shape of 100 mm", rig::tips_in_organic_shape(tips),
            [](int divisions) { return rig::organic_surface(divisions, rig::kTestOrganicScale_m); },
            [](const Vector3 &vertex_m) {
                return rig::organic_shape().outward_normal(vertex_m / rig::kTestOrganicScale_m);
            },
            std::nullopt};
}

TouchTrial thin_plate_trial(std::size_t tips) {
    return {"a plate of 2 mm", rig::tips_in_thin_plate(tips), plate_mesh, nullptr,
            about_origin(contact::Box{rig::thin_plate_half_size_m()})};
}

contact::TriangleSoup bent(const contact::TriangleSoup &soup,
                           const std::function<Vector3(const Vector3 &)> &normal) {
    scene::SmoothMesh mesh;
    mesh.positions = soup.vertices_m;
    mesh.triangles = soup.triangles;
    for (const Vector3 &vertex_m : soup.vertices_m) {
        mesh.normals.push_back(normal(vertex_m));
    }
    const scene::CurvedPatches patches(std::move(mesh));
    const auto maximum =
        static_cast<std::size_t>(std::sqrt(static_cast<double>(scene::gltf::kMaxCurvedTriangles) /
                                           static_cast<double>(soup.triangles.size())));
    const std::size_t cuts = patches.cuts_for(scene::gltf::kSmooth_deg * kRadiansPerDegree,
                                              std::clamp<std::size_t>(maximum, 1, kMaxCuts));
    scene::SmoothMesh curved = patches.cut(cuts, 0, soup.triangles.size());
    contact::TriangleSoup fine;
    fine.vertices_m = std::move(curved.positions);
    fine.triangles = std::move(curved.triangles);
    fine.material_of_triangle.assign(fine.triangles.size(), 0);
    fine.materials = soup.materials;
    return fine;
}

} // namespace springdrive::charts
