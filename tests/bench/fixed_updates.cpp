// A fixed number of the proxy's updates over one fixed input, for tests/bench/count_instructions:
//   fixed_updates INPUT UPDATES
// Ends with an error if a contact is not of the input's intended kind.
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "tests/bench/touch_path.h"
#include "tests/engine/contact/mesh/soups.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using namespace springdrive;
using namespace springdrive::bench;

constexpr int kUpdates = 1000;

struct FixedInput {
    contact::TriangleSoup soup;
    Vector3 start_m{Vector3::Zero()};
    std::vector<Vector3> tips_m;
    std::vector<Vector3> resets_m; ///< where the proxy is put before each update, if it is
    int min_constraints = 0;       ///< of every contact
    int max_constraints = 0;
};

contact::TriangleSoup sphere() { return *rig::test_surface_named("sphere:20480"); }

FixedInput sliding() {
    FixedInput input{sphere(), {}, pressed_tips_m(Relief::smooth, lissajous_directions(kUpdates)),
                     {},       1,  3};
    input.start_m = 1.5 * input.tips_m.front();
    return input;
}

FixedInput in_free_space() {
    FixedInput input{sphere(), {}, free_tips_m(Relief::smooth, lissajous_directions(kUpdates)), {}};
    input.start_m = input.tips_m.front();
    return input;
}

/// Directions that are spread evenly, one far from the next.
std::vector<Vector3> spread_directions() {
    std::vector<Vector3> directions;
    for (int i = 0; i < kUpdates; ++i) {
        const double height = 1.0 - (2.0 * ((i * 377) % kUpdates) + 1.0) / kUpdates;
        const double angle = 2.0 * std::numbers::pi * std::numbers::phi * i;
        const double across = std::sqrt(1.0 - height * height);
        directions.emplace_back(across * std::cos(angle), height, across * std::sin(angle));
    }
    return directions;
}

/// The tip crosses to another side of the sphere with each update.
FixedInput leaping() {
    FixedInput input{sphere(), {}, pressed_tips_m(Relief::smooth, spread_directions()), {}, 1, 3};
    input.start_m = 1.5 * input.tips_m.front();
    return input;
}

/// Always at a place with no neighbourhood yet.
FixedInput gathering() {
    FixedInput input = leaping();
    for (const Vector3 &tip_m : input.tips_m) {
        input.resets_m.emplace_back((rig::kTestSphereRadius_m + 5e-4) * tip_m.normalized());
    }
    return input;
}

/// Walls of 60 mm in the planes x = 0, y = 0 and z = 0, which meet at the origin.
contact::TriangleSoup walls(int count) {
    constexpr double kHalf_m = 0.03;
    contact::TriangleSoup soup;
    for (int wall = 0; wall < count; ++wall) {
        contact::TriangleSoup sheet = testing::sheet(10, kHalf_m);
        for (Vector3 &vertex : sheet.vertices_m) {
            vertex += Vector3(kHalf_m, 0.0, kHalf_m);
            std::rotate(vertex.data(), vertex.data() + wall, vertex.data() + 3);
        }
        soup = testing::joined(std::move(soup), sheet);
    }
    return soup;
}

/// Behind two walls, back and forth along their edge, or behind three, about their corner.
FixedInput between_walls(int count) {
    FixedInput input{walls(count), Vector3(0.01, 0.01, 0.01), {}, {}, count, count};
    // The walls y = 0 and x = 0 have the edge along z, the first two.
    for (int i = 0; i < kUpdates; ++i) {
        const double phase = 2.0 * std::numbers::pi * i / kUpdates;
        Vector3 tip_m(-1e-3 + 2e-4 * std::cos(phase), -1e-3 + 2e-4 * std::sin(phase), -1e-3);
        if (count == 2) {
            tip_m.z() = 0.03 + 0.0159 * std::sin(phase);
        }
        input.tips_m.push_back(tip_m);
    }
    return input;
}

FixedInput input_named(std::string_view name) {
    if (name == "free") {
        return in_free_space();
    }
    if (name == "slide") {
        return sliding();
    }
    if (name == "edge") {
        return between_walls(2);
    }
    if (name == "corner") {
        return between_walls(3);
    }
    if (name == "cold_gather") {
        return gathering();
    }
    if (name == "leap") {
        return leaping();
    }
    throw std::invalid_argument("no input of that name");
}

/// Counted by its name; its overhead is a few instructions per update.
[[gnu::noinline]] int run_updates(contact::Proxy &proxy, const contact::HapticSurface &surface,
                                  const FixedInput &input, std::size_t updates) {
    int as_meant = 0;
    for (std::size_t i = 0; i < updates; ++i) {
        if (!input.resets_m.empty()) {
            proxy.reset(input.resets_m[i]);
        }
        const contact::Contact contact = proxy.update(surface, input.tips_m[i]);
        as_meant += contact.active_constraints >= input.min_constraints &&
                    contact.active_constraints <= input.max_constraints;
    }
    return as_meant;
}

} // namespace

int main(int argc, char **argv) {
    try {
        if (argc != 3) {
            throw std::invalid_argument("give INPUT and UPDATES");
        }
        const FixedInput input = input_named(argv[1]);
        const std::size_t updates = std::stoul(argv[2]);
        if (updates > input.tips_m.size()) {
            throw std::invalid_argument("1000 updates at most");
        }
        const contact::HapticSurface surface(input.soup);
        contact::Proxy proxy;
        proxy.reset(input.start_m);
        if (run_updates(proxy, surface, input, updates) != static_cast<int>(updates)) {
            throw std::runtime_error("a contact is not of the kind meant");
        }
    } catch (const std::exception &error) {
        std::fprintf(stderr, "fixed_updates: %s\n", error.what());
        return 1;
    }
    return 0;
}
