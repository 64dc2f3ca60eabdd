#include "engine/scene/load_progress.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::scene {

std::string LoadProgress::text() const {
    constexpr std::array<const char *, 6> kStages = {"reading the file",
                                                     "gathering triangles",
                                                     "bending smooth surfaces",
                                                     "placing the scene",
                                                     "preparing the surface for touch",
                                                     "measuring models"};
    const std::string stage = kStages[static_cast<std::size_t>(stage_.load())];
    const float fraction = fraction_;
    if (fraction < 0.0F) {
        return stage;
    }
    const long percent = std::lround(100.0 * std::clamp(static_cast<double>(fraction), 0.0, 1.0));
    return stage + ", " + std::to_string(percent) + " %";
}

} // namespace springdrive::scene
