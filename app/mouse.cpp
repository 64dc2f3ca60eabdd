#include "app/mouse.h"

#include <imgui.h>

namespace springdrive {

namespace {

/// How far one notch of the wheel moves the hand in depth.
constexpr double kDepthPerNotch_m = 0.002;

} // namespace

void MouseInView::apply(Session &session, Camera &camera, const Rectangle &view) {
    const ImGuiIO &io = ImGui::GetIO();
    const bool over_view = view.contains(io.MousePos) && !io.WantCaptureMouse;
    if (over_view && dragging_ == Drag::none) {
        if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
            dragging_ = Drag::hand;
        } else if (ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
            dragging_ = Drag::orbit;
        } else if (ImGui::IsMouseClicked(ImGuiMouseButton_Middle)) {
            dragging_ = Drag::pan;
        }
    }
    const double dx = io.MouseDelta.x;
    const double dy = io.MouseDelta.y;
    const double height = view.size.y;
    const bool may_move_hand = !session.hand_follows_path();
    switch (dragging_) {
    case Drag::hand:
        if (may_move_hand) {
            const Vector3 &target_m = session.hand_target_m();
            const double pixel_m = camera.metres_per_pixel(target_m, height);
            session.move_hand_to(target_m + pixel_m * (dx * camera.right() - dy * camera.up()) +
                                 io.MouseWheel * kDepthPerNotch_m * camera.forward());
        }
        break;
    case Drag::orbit:
        camera.orbit(dx, dy);
        break;
    case Drag::pan:
        camera.pan(dx, dy, height);
        break;
    case Drag::none:
        break;
    }
    if (io.MouseWheel != 0.0F && over_view && dragging_ != Drag::hand) {
        camera.zoom(io.MouseWheel);
    }
    const bool released =
        (dragging_ == Drag::hand && !ImGui::IsMouseDown(ImGuiMouseButton_Left)) ||
        (dragging_ == Drag::orbit && !ImGui::IsMouseDown(ImGuiMouseButton_Right)) ||
        (dragging_ == Drag::pan && !ImGui::IsMouseDown(ImGuiMouseButton_Middle));
    if (released) {
        dragging_ = Drag::none;
    }
}

} // namespace springdrive
