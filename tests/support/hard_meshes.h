// Generated meshes of the kinds on which proxies fail, and tips that touch them everywhere.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace springdrive::testing {

/// A few dozen to some thousand triangles, 1 to 100 mm large, anywhere within 0.1 m of the origin.
struct HardMesh {
    std::string name;
    contact::TriangleSoup soup;
};

struct HardMeshKind {
    std::string_view name;
    contact::TriangleSoup (*make)(std::mt19937_64 &random);
};

/// Height fields with noise and holes, as of a scanner.
[[nodiscard]] contact::TriangleSoup scan(std::mt19937_64 &random);
/// Two planes that meet in a finely divided fillet, convex or concave, of triangles up to
/// 1 : 10,000.
[[nodiscard]] contact::TriangleSoup fillet(std::mt19937_64 &random);
/// Up to 600 triangles around one vertex: saddles, wavy cones, pits and spikes, sharp and blunt.
[[nodiscard]] contact::TriangleSoup fan(std::mt19937_64 &random);
/// Triangles at one edge.
[[nodiscard]] contact::TriangleSoup book(std::mt19937_64 &random);
/// Two height fields a few hundred nanometres to half a millimetre apart.
[[nodiscard]] contact::TriangleSoup thin_shell(std::mt19937_64 &random);
/// A bumpy ball without its top: closed but for one rim.
[[nodiscard]] contact::TriangleSoup open_ball(std::mt19937_64 &random);
/// Triangles of all sizes that intersect each other at random.
[[nodiscard]] contact::TriangleSoup tangle(std::mt19937_64 &random);

/// A block with rounded edges and a shaft on it, as a CAD system exports it, stretched at random.
[[nodiscard]] contact::TriangleSoup machined_part(std::mt19937_64 &random);
/// A scan whose triangles are divided once or twice: flat but for the rounding of their corners.
[[nodiscard]] contact::TriangleSoup subdivided_scan(std::mt19937_64 &random);
/// One of the kinds above up to half a metre away, its coordinates in 32 bits.
[[nodiscard]] contact::TriangleSoup in_32_bits(std::mt19937_64 &random);
/// Two or three height fields that intersect at any angle.
[[nodiscard]] contact::TriangleSoup crossing_fields(std::mt19937_64 &random);
/// Boxes and balls that intersect.
[[nodiscard]] contact::TriangleSoup crossing_bodies(std::mt19937_64 &random);

inline constexpr std::array<HardMeshKind, 12> kHardMeshKinds{{
    {"scan", scan},
    {"fillet", fillet},
    {"fan", fan},
    {"book", book},
    {"thin_shell", thin_shell},
    {"open_ball", open_ball},
    {"tangle", tangle},
    {"machined_part", machined_part},
    {"subdivided_scan", subdivided_scan},
    {"in_32_bits", in_32_bits},
    {"crossing_fields", crossing_fields},
    {"crossing_bodies", crossing_bodies},
}};

/// One of a kind: with shared vertices or torn into separate triangles, touched from one side, from
/// both or as it is closed, turned and moved at random.
[[nodiscard]] HardMesh hard_mesh(const HardMeshKind &kind, std::uint64_t seed);

/// A tip that presses into faces, edges and vertices of a mesh to a depth of 10 µm to 5 mm, slides
/// on to the next place at once or slowly, and sometimes leaves.
class ProbingTip {
public:
    ProbingTip(const contact::TriangleSoup &soup, std::uint64_t seed);

    [[nodiscard]] const Vector3 &position_m() const { return tip_m_; }
    const Vector3 &advance();

private:
    [[nodiscard]] Vector3 place_in_the_mesh();

    const contact::TriangleSoup &soup_;
    std::mt19937_64 random_;
    Eigen::AlignedBox3d box_;
    double step_m_ = 0.0;
    Vector3 tip_m_{Vector3::Zero()};
    Vector3 aim_m_{Vector3::Zero()};
    Vector3 wobble_{Vector3::UnitX()};
    int steps_left_ = 0;
    bool is_fast_ = true;
};

} // namespace springdrive::testing
