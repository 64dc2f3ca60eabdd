// Colours of the participant's screen: dark and neutral, with one accent. sRGB, straight alpha.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace springdrive::app::study_screen::palette {

// Contrasts by WCAG 2.1 on the ground: ink 14, dim ink 7.
inline const glm::vec3 kGround{0.105F, 0.115F, 0.130F};
inline const glm::vec4 kInk{0.925F, 0.935F, 0.945F, 1.0F};
inline const glm::vec4 kDimInk{0.655F, 0.680F, 0.710F, 1.0F};
inline const glm::vec4 kAccent{0.530F, 0.770F, 0.945F, 1.0F};
inline const glm::vec4 kPlate{0.170F, 0.187F, 0.212F, 1.0F};
inline const glm::vec4 kPlateRim{0.300F, 0.325F, 0.360F, 1.0F};
inline const glm::vec4 kChosenPlate{0.180F, 0.275F, 0.345F, 1.0F};
inline const glm::vec4 kTrough{0.200F, 0.218F, 0.245F, 1.0F}; // of bars

} // namespace springdrive::app::study_screen::palette
