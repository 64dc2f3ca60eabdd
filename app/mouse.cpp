#include "app/mouse.h"

#include <imgui.h>

namespace springdrive::app {

namespace {

/// Movement of the hand in depth by one notch of the wheel.
constexpr double kDepthPerNotch_m = 0.002;

} // namespace

void MouseInView::apply(session::Session &session, Camera &camera, const Rectangle &view,
                        bool may_move_hand,
                        const std::function<Vector3(const PixelPoint &)> &point_under) {
    const ImGuiIO &io = ImGui::GetIO();
    const bool over_view = view.contains(io.MousePos) && !io.WantCaptureMouse;
    // A drag ends before this frame's motion, which is not part of it.
    const bool released =
        (dragging_ == Drag::hand && !ImGui::IsMouseDown(ImGuiMouseButton_Left)) ||
        (dragging_ == Drag::orbit && !ImGui::IsMouseDown(ImGuiMouseButton_Right)) ||
        (dragging_ == Drag::pan && !ImGui::IsMouseDown(ImGuiMouseButton_Middle));
    if (released) {
        dragging_ = Drag::none;
    }
    const bool was_dragging = dragging_ != Drag::none;
    if (over_view && !was_dragging) {
        if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
            dragging_ = Drag::hand;
            grabbed_m_ = session.hand().target_m();
        } else if (ImGui::IsMouseClicked(ImGuiMouseButton_Right)) {
            dragging_ = Drag::orbit;
        } else if (ImGui::IsMouseClicked(ImGuiMouseButton_Middle)) {
            dragging_ = Drag::pan;
        }
    }
    // Motion before the start of a drag is not part of it.
    const double dx = was_dragging ? io.MouseDelta.x : 0.0;
    const double dy = was_dragging ? io.MouseDelta.y : 0.0;
    const double height = view.size.y;
    may_move_hand = may_move_hand && !session.hand().follows_path();
    switch (dragging_) {
    case Drag::hand:
        if (may_move_hand) {
            const double pixel_m = camera.metres_per_pixel(grabbed_m_, height);
            grabbed_m_ += pixel_m * (dx * camera.right() - dy * camera.up()) +
                          io.MouseWheel * kDepthPerNotch_m * camera.forward();
            session.hand().move_to(grabbed_m_);
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
        camera.zoom(io.MouseWheel,
                    point_under({io.MousePos.x - view.corner.x, io.MousePos.y - view.corner.y}));
    }
}

} // namespace springdrive::app
