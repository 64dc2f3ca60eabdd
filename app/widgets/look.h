// Colours and spacing of the whole window.
#pragma once

#include <imgui.h>

namespace springdrive::app {

inline const ImVec4 kInk{0.90F, 0.92F, 0.94F, 1.0F};
inline const ImVec4 kFaintInk{0.60F, 0.64F, 0.69F, 1.0F};
inline const ImVec4 kTransposeMap{0.36F, 0.73F, 0.95F, 1.0F};
inline const ImVec4 kInverseMap{1.0F, 0.52F, 0.32F, 1.0F};
inline const ImVec4 kForce{1.0F, 0.86F, 0.16F, 1.0F}; ///< as the arrow in the scene
inline const ImVec4 kGood{0.35F, 0.85F, 0.60F, 1.0F};
inline const ImVec4 kWarning{1.0F, 0.72F, 0.35F, 1.0F};
inline const ImVec4 kDanger{1.0F, 0.38F, 0.34F, 1.0F};

/// Sets a dark style for `scale`. To be called after ImGui::CreateContext, and when the scale
/// changes.
void apply_look(float scale);

} // namespace springdrive::app
