// Mouse control of camera and hand in the scene view.
#include "app/stage/view_control.h"

#include <imgui.h>

namespace springdrive::app {

namespace {

/// Movement of the hand in depth by one notch of the wheel.
constexpr double kDepthPerNotch_m = 0.002;

TouchGround ground_of(const session::Session &session) {
    const session::LoadedScene &now = session.scenes().now();
    return {now.surface, now.scene.lower_m, now.scene.upper_m, session.description().workspace};
}

} // namespace

void MouseInView::apply(session::Session &session, Camera &camera, const Rectangle &view,
                        bool may_move_hand, const SeenAt &seen) {
    const ImGuiIO &io = ImGui::GetIO();
    const PixelPoint pixel{io.MousePos.x - view.corner.x, io.MousePos.y - view.corner.y};
    const bool over_view = view.contains(io.MousePos) && !io.WantCaptureMouse;
    may_move_hand = may_move_hand && !session.hand().follows_path();
    // A drag ends before this frame's motion, which is not part of it.
    const bool released =
        (holds_hand() && !ImGui::IsMouseDown(ImGuiMouseButton_Left)) ||
        (dragging_ == Drag::orbit && !ImGui::IsMouseDown(ImGuiMouseButton_Right)) ||
        (dragging_ == Drag::pan && !ImGui::IsMouseDown(ImGuiMouseButton_Middle));
    if (released) {
        if (dragging_ == Drag::touch) {
            touch_.let_go(ground_of(session), session.latest().contact);
        }
        dragging_ = Drag::none;
    }
    const bool was_dragging = dragging_ != Drag::none;
    if (over_view && !was_dragging) {
        if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
            begin_with_hand(session, seen, pixel, may_move_hand);
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
    case Drag::touch:
    case Drag::none:
        break;
    }
    if (touch_.is_on() && may_move_hand) {
        move_touch(session, seen, pixel);
    } else {
        touch_.stop();
    }
    if (io.MouseWheel != 0.0F && over_view && !holds_hand()) {
        camera.zoom(io.MouseWheel, seen.point(pixel));
    }
}

void MouseInView::begin_with_hand(const session::Session &session, const SeenAt &seen,
                                  const PixelPoint &pixel, bool may_move_hand) {
    dragging_ = Drag::hand;
    grabbed_m_ = session.hand().target_m();
    touch_.stop();
    if (!may_move_hand || !session.hand().is_simulated() || ImGui::GetIO().KeyShift) {
        return;
    }
    if (const auto place = seen.touchable(pixel)) {
        dragging_ = Drag::touch;
        touch_.press(ground_of(session), session.latest().contact, grabbed_m_, *place);
        asked_m_ = grabbed_m_;
    }
}

/// Unless something else has moved the hand meanwhile.
void MouseInView::move_touch(session::Session &session, const SeenAt &seen,
                             const PixelPoint &pixel) {
    if (session.hand().target_m() != asked_m_) {
        touch_.stop();
        return;
    }
    if (dragging_ == Drag::touch) {
        if (const auto place = seen.touchable(pixel)) {
            touch_.aim(ground_of(session), session.latest().contact, *place);
        }
        if (const float notches = ImGui::GetIO().MouseWheel; notches != 0.0F) {
            touch_.deepen(notches * kDepthPerNotch_m);
        }
    }
    session.hand().move_to(touch_.next_m(ImGui::GetIO().DeltaTime));
    asked_m_ = session.hand().target_m();
}

} // namespace springdrive::app
