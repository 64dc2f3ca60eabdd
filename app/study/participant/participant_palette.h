// Colours of the participant's screen: dark and neutral, with one accent. sRGB, straight alpha.
#pragma once

#include <glm/vec3.hpp>
#include <imgui.h>

namespace springdrive::app::study_screen::palette {

// Contrasts by WCAG 2.1 on the ground: ink 14, dim ink 7.
inline constexpr glm::vec3 kGround{0.105F, 0.115F, 0.130F};
inline constexpr ImU32 kInk = IM_COL32(236, 238, 241, 255);
inline constexpr ImU32 kDimInk = IM_COL32(167, 173, 181, 255);
inline constexpr ImU32 kAccent = IM_COL32(135, 196, 241, 255);
inline constexpr ImU32 kCard = IM_COL32(43, 48, 54, 255);
inline constexpr ImU32 kPlateRim = IM_COL32(76, 83, 92, 255);
inline constexpr ImU32 kChosenCard = IM_COL32(46, 70, 88, 255);
inline constexpr ImU32 kTrough = IM_COL32(51, 56, 62, 255); // of bars

} // namespace springdrive::app::study_screen::palette
