#include "app/stage/view_control.h"

#include "app/view/camera.h"
#include "app/view/pick.h"
#include "app/view/renderer.h"
#include "app/view/solids.h"
#include "app/widgets/widgets.h"
#include "device/core/phantom/kinematics.h"
#include "engine/scene/scripted_touch.h"

#include <imgui.h>

#include <algorithm>
#include <vector>

namespace springdrive::app {

namespace {

PixelSize size_of(const Rectangle &view) { return {view.size.x, view.size.y}; }

/// In the view's own pixels.
PixelRectangle within(const Rectangle &part, const Rectangle &view) {
    const double left = part.corner.x - view.corner.x;
    const double top = part.corner.y - view.corner.y;
    return {{left, top}, {left + part.size.x, top + part.size.y}};
}

/// Points that contain the scene, and the device as it stands.
std::vector<Vector3> shown_points(const scene::Scene &scene, const ViewState &state) {
    std::vector<Solid> solids = linkage_solids(state.linkage, state.floor_height_m, state.tripped);
    solids.push_back(ball(state.tip_m, kTipRadius_m, kTipColour));
    std::vector<Vector3> points_m = drawn_points(solids);
    const auto corners = box_corners(scene.lower_m, scene.upper_m);
    points_m.insert(points_m.end(), corners.begin(), corners.end());
    return points_m;
}

/// The same with the device where it starts, too: wherever the tip is when a viewpoint is chosen,
/// its way back is in the picture.
std::vector<Vector3> framed_points(const session::Session &session, const ViewState &state) {
    const scene::Scene &scene = session.scenes().now().scene;
    const device::DeviceDescription &device = session.description();
    std::vector<Vector3> points_m = shown_points(scene, state);
    ViewState start = state;
    start.tip_m = scene::start_above(device, scene.lower_m, scene.upper_m);
    if (const auto q_rad = device::joint_angles_rad(device.geometry, start.tip_m)) {
        start.linkage = device::linkage_pose(device.geometry, *q_rad);
        const std::vector<Vector3> at_start_m = shown_points(scene, start);
        points_m.insert(points_m.end(), at_start_m.begin(), at_start_m.end());
    }
    return points_m;
}

/// What is under a pixel; where nothing is, the point at the target's depth.
Vector3 point_under(const Camera &camera, const PixelPoint &pixel, const PixelSize &viewport,
                    const scene::Scene &scene, const ViewState &state) {
    const Ray ray = line_of_sight(camera, pixel, viewport);
    const std::vector<Solid> linkage = linkage_solids(state.linkage, state.floor_height_m, false);
    std::optional<double> nearest_m;
    for (const std::optional<double> &hit_m :
         {first_hit_m(ray, scene.meshes), first_hit_m(ray, linkage),
          floor_hit_m(ray, state.floor_height_m)}) {
        if (hit_m && (!nearest_m || *hit_m < *nearest_m)) {
            nearest_m = hit_m;
        }
    }
    // The floor ends somewhere, and what is far behind the target would draw the view away.
    constexpr double kFarthest = 2.0; // times the target's distance
    return nearest_m && *nearest_m < kFarthest * camera.distance_m()
               ? Vector3(ray.origin_m + *nearest_m * ray.direction)
               : camera.point_at(pixel, viewport, camera.target_m());
}

/// What can be touched under a pixel, also behind the device, which is in the way of most clicks.
std::optional<SurfacePlace> touchable_under(const Camera &camera, const PixelPoint &pixel,
                                            const PixelSize &viewport,
                                            const contact::HapticSurface &surface) {
    constexpr double kFarthest = 4.0; // times the target's distance
    const Ray ray = line_of_sight(camera, pixel, viewport);
    return first_touchable(surface, ray.origin_m,
                           ray.origin_m + kFarthest * camera.distance_m() * ray.direction);
}

/// Movement of the hand in depth by one notch of the wheel.
constexpr double kDepthPerNotch_m = 0.002;

TouchGround ground_of(const session::Session &session) {
    const session::LoadedScene &now = session.scenes().now();
    return {now.surface, now.scene.lower_m, now.scene.upper_m, session.description().workspace};
}

} // namespace

ViewState view_of(const servo::ServoSample &now, const device::DeviceDescription &device,
                  const contact::HapticSurface &surface) {
    ViewState state;
    state.linkage = device::linkage_pose(device.geometry,
                                         device::joint_from_motor(device.geometry, now.theta_rad));
    state.tip_m = now.tip_m;
    state.proxy_m = now.contact.x0_m;
    state.touching = now.contact.touching;
    state.normal = now.contact.normal;
    state.tip_force_N = now.tip_force_N;
    state.hand_target_m = now.tip_m;
    state.tripped = now.safety.state == servo::SafetyState::tripped;
    state.workspace = device.workspace;
    state.floor_height_m = device.workspace.centre_m.y() - 0.5 * device.workspace.size_m.y();
    state.below =
        place_below(surface, state.touching ? state.proxy_m : state.tip_m, state.floor_height_m);
    return state;
}

bool ViewControl::obey(std::string_view key) {
    constexpr double kTurn_px = 12.0;
    const Camera before = camera_;
    if (key == "Home") {
        look_from(Viewpoint::home);
    } else if (key == "t") {
        look_from(Viewpoint::top);
    } else if (key == "f") {
        look_from(Viewpoint::front);
    } else if (key == "j" || key == "l") {
        camera_.orbit(key == "j" ? -kTurn_px : kTurn_px, 0.0);
    } else if (key == "i" || key == "k") {
        camera_.orbit(0.0, key == "i" ? -kTurn_px : kTurn_px);
    } else if (key == "u" || key == "o") {
        camera_.zoom(key == "u" ? 1.0 : -1.0, camera_.target_m());
    } else {
        return false;
    }
    if (camera_ != before) {
        kept_.reset();
    }
    return true;
}

void ViewControl::update(session::Session &session, const ViewState &state, const Rectangle &view,
                         const Rectangle &free, bool may_move_hand) {
    const PixelSize size = size_of(view);
    const Camera before = camera_;
    apply_mouse(session, state, view, may_move_hand);
    if (camera_ != before) {
        kept_.reset();
    }
    is_framed_ = is_framed_ && framed_size_ == size && framed_free_ == free &&
                 framed_base_m_ == state.linkage.base_m;
    if (kept_ && !is_framed_ && free.size.x > 0.0F && free.size.y > 0.0F) {
        camera_.look_from(*kept_);
        camera_ = framed(camera_, framed_points(session, state), size, within(free, view));
        is_framed_ = true;
        framed_size_ = size;
        framed_free_ = free;
        framed_base_m_ = state.linkage.base_m;
    }
}

void ViewControl::report(const session::Session &session, const ViewState &state,
                         const Rectangle &view) const {
    if (!ui::report().is_requested()) {
        return;
    }
    const PixelRectangle part =
        drawn_part(camera_, shown_points(session.scenes().now().scene, state), size_of(view));
    const auto left = static_cast<float>(part.top_left.x_px);
    const auto top = static_cast<float>(part.top_left.y_px);
    ui::enter_at({{view.corner.x + left, view.corner.y + top},
                  {static_cast<float>(part.bottom_right.x_px) - left,
                   static_cast<float>(part.bottom_right.y_px) - top}},
                 "device and scene", "drawing", "");
}

void ViewControl::draw(Renderer &renderer, const ViewState &state, const Rectangle &view,
                       const Window &window) const {
    const float scale = window.pixel_scale();
    const auto pixel = [&](float units) { return static_cast<int>(units * scale); };
    const ViewportPixels viewport{pixel(view.corner.x),
                                  window.framebuffer().height - pixel(view.corner.y + view.size.y),
                                  pixel(view.size.x), pixel(view.size.y)};
    if (viewport.width > 0 && viewport.height > 0) {
        renderer.draw(camera_, viewport, state, scale * window.scale(), window.is_drawn());
    }
}

void ViewControl::apply_mouse(session::Session &session, const ViewState &state,
                              const Rectangle &view, bool may_move_hand) {
    const PixelSize size = size_of(view);
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
            begin_with_hand(session, pixel, size, may_move_hand);
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
            const double pixel_m = camera_.metres_per_pixel(grabbed_m_, height);
            grabbed_m_ += pixel_m * (dx * camera_.right() - dy * camera_.up()) +
                          io.MouseWheel * kDepthPerNotch_m * camera_.forward();
            session.hand().move_to(grabbed_m_);
        }
        break;
    case Drag::orbit:
        camera_.orbit(dx, dy);
        break;
    case Drag::pan:
        camera_.pan(dx, dy, height);
        break;
    case Drag::touch:
    case Drag::none:
        break;
    }
    if (touch_.is_on() && may_move_hand) {
        move_touch(session, pixel, size);
    } else {
        touch_.stop();
    }
    if (io.MouseWheel != 0.0F && over_view && !holds_hand()) {
        camera_.zoom(io.MouseWheel,
                     point_under(camera_, pixel, size, session.scenes().now().scene, state));
    }
}

void ViewControl::begin_with_hand(const session::Session &session, const PixelPoint &pixel,
                                  const PixelSize &size, bool may_move_hand) {
    dragging_ = Drag::hand;
    grabbed_m_ = session.hand().target_m();
    touch_.stop();
    if (!may_move_hand || !session.hand().is_simulated() || ImGui::GetIO().KeyShift) {
        return;
    }
    if (const auto place = touchable_under(camera_, pixel, size, session.scenes().now().surface)) {
        dragging_ = Drag::touch;
        touch_.press(ground_of(session), session.latest().contact, grabbed_m_, *place);
        requested_m_ = grabbed_m_;
    }
}

/// Unless something else has moved the hand meanwhile.
void ViewControl::move_touch(session::Session &session, const PixelPoint &pixel,
                             const PixelSize &size) {
    if (session.hand().target_m() != requested_m_) {
        touch_.stop();
        return;
    }
    if (dragging_ == Drag::touch) {
        if (const auto place =
                touchable_under(camera_, pixel, size, session.scenes().now().surface)) {
            touch_.aim(ground_of(session), session.latest().contact, *place);
        }
        if (const float notches = ImGui::GetIO().MouseWheel; notches != 0.0F) {
            touch_.deepen(notches * kDepthPerNotch_m);
        }
    }
    session.hand().move_to(touch_.next_m(ImGui::GetIO().DeltaTime));
    requested_m_ = session.hand().target_m();
}

} // namespace springdrive::app
