#include "app/panels/scene_overlay.h"

#include "app/view/view_state.h"
#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <system_error>
#include <vector>

namespace springdrive::app {

namespace {

const ImVec4 kCard{0.07F, 0.08F, 0.10F, 0.88F};

float card_margin(float scale) { return 8.0F * scale; }

float card_width(const Rectangle &view, float scale) {
    return std::min(320.0F * scale, 0.42F * view.size.x);
}

/// The file at this distance in the list from the one that is shown, the first behind the last;
/// null if the shown one is not in the list.
const std::filesystem::path *neighbour(std::span<const std::filesystem::path> files,
                                       const std::filesystem::path &shown, std::ptrdiff_t by) {
    std::error_code ignored;
    const auto found = std::ranges::find(files, absolute(shown, ignored).lexically_normal());
    if (found == files.end()) {
        return nullptr;
    }
    const auto count = static_cast<std::ptrdiff_t>(files.size());
    return &files[static_cast<std::size_t>((found - files.begin() + by + count) % count)];
}

void draw_neighbour_button(session::Session &session, std::span<const std::filesystem::path> files,
                           const char *label, std::ptrdiff_t by) {
    const std::filesystem::path *const file =
        neighbour(files, session.scenes().now().scene.file, by);
    const ui::Disabled disabled(file == nullptr || session.scenes().is_loading());
    if (ui::small_button(label) && file != nullptr) {
        session.request_scene(*file);
    }
    ui::explain(file == nullptr ? "This scene is not in the list." : file->filename().string());
}

/// Title, and the buttons in its row.
void draw_head(session::Session &session, std::span<const std::filesystem::path> files,
               SceneCardState &state) {
    const scene::Scene &scene = session.scenes().now().scene;
    const float button = ImGui::CalcTextSize("<").x + 2.0F * ImGui::GetStyle().FramePadding.x;
    const float gap = 0.5F * ImGui::GetStyle().ItemSpacing.x;
    const float room = 3.0F * button + 2.0F * gap;
    const float left = ImGui::GetWindowContentRegionMax().x - room;
    ImGui::PushTextWrapPos(left - gap);
    ui::text(kForce, "{}",
             scene.lesson.title.empty() ? scene.file.filename().string() : scene.lesson.title);
    ImGui::PopTextWrapPos();
    ImGui::SameLine(left);
    draw_neighbour_button(session, files, "<##previous", -1);
    ImGui::SameLine(0.0F, gap);
    draw_neighbour_button(session, files, ">##next", 1);
    ImGui::SameLine(0.0F, gap);
    if (ui::small_button("×##put away")) {
        state.is_put_away = true;
    }
    ui::explain("Puts this away. The tab Scene brings it back.");
}

/// Takes the latest measurement into the map's place.
void measure(const session::Session &session, SceneCardState &state) {
    static const std::array<std::optional<std::size_t>, 2> kChannels{
        session::channel_named("inverse_measured_rad"),
        session::channel_named("transpose_measured_rad")};
    const record::ChannelStore &store = session.servo().history().store();
    for (std::size_t map = 0; map < kChannels.size(); ++map) {
        if (!store.is_empty() && kChannels[map]) {
            const double angle_rad = store.value(*kChannels[map], store.end() - 1);
            if (std::isfinite(angle_rad)) {
                state.angle_rad[map] = angle_rad;
            }
        }
    }
}

/// One row a map, the active one large.
void draw_angles(session::Session &session, TuningEditor &editor, const SceneCardState &state) {
    constexpr float kLarge = 1.5F;
    constexpr std::array<control::MotionMap, 2> kMaps{control::MotionMap::inverse,
                                                      control::MotionMap::transpose};
    for (const control::MotionMap map : kMaps) {
        const bool is_active = session.tuning().now().map == map;
        const auto &angle_rad = state.angle_rad[static_cast<std::size_t>(map)];
        const ImVec4 &colour = !is_active                           ? kFaintInk
                               : map == control::MotionMap::inverse ? kInverseMap
                                                                    : kTransposeMap;
        const ui::Scope scope(control::name_of(map));
        const float row_y = ImGui::GetCursorPosY();
        ImGui::SetWindowFontScale(is_active ? kLarge : 1.0F);
        ui::text(colour, "{}",
                 angle_rad ? ui::formatted("{:.0f}°", *angle_rad * kDegreesPerRadian) : "–");
        const float baseline = ImGui::GetFontSize();
        ImGui::SetWindowFontScale(1.0F);
        ui::explain("Angle between the surface's normal and the push, as measured by the\n"
                    "currents, below 30 Hz; of the map that is not in use, as it was last.");
        ImGui::SameLine();
        ImGui::SetCursorPosY(row_y + 0.8F * (baseline - ImGui::GetFontSize()));
        ui::text(colour, "{}, {}", angle_rad ? "off" : "not measured yet", control::label_of(map));
    }
    if (ui::small_button("the other map  (M)###other map")) {
        editor.toggle_map();
    }
}

bool overlap(const Rectangle &a, const Rectangle &b) {
    return a.corner.x < b.end().x && b.corner.x < a.end().x && a.corner.y < b.end().y &&
           b.corner.y < a.end().y;
}

/// Draws captions one by one, each above those that it would cover.
class Captions {
public:
    Captions(const Camera &camera, const Rectangle &view, float scale)
        : camera_(camera), view_(view), scale_(scale), list_(*ImGui::GetBackgroundDrawList()) {
        list_.PushClipRect(view.corner, view.end(), true);
    }
    ~Captions() { list_.PopClipRect(); }
    Captions(const Captions &) = delete;
    Captions &operator=(const Captions &) = delete;

    /// Captions stand beside what lies between these points, such as the tip and its force.
    void keep_clear(const Vector3 &from_m, const Vector3 &to_m) {
        const auto from = camera_.pixel_of(from_m, PixelSize{view_.size.x, view_.size.y});
        const auto to = camera_.pixel_of(to_m, PixelSize{view_.size.x, view_.size.y});
        if (!from || !to) {
            return;
        }
        const float around = 16.0F * scale_;
        const auto [left, right] = std::minmax(from->x_px, to->x_px);
        const auto [top, bottom] = std::minmax(from->y_px, to->y_px);
        clear_ = Rectangle{{view_.corner.x + static_cast<float>(left) - around,
                            view_.corner.y + static_cast<float>(top) - around},
                           {static_cast<float>(right - left) + 2.0F * around,
                            static_cast<float>(bottom - top) + 2.0F * around}};
    }

    void draw(const scene::Caption &caption, const ImVec4 &colour) {
        const auto pixel = camera_.pixel_of(caption.at_m, PixelSize{view_.size.x, view_.size.y});
        if (!pixel) {
            return;
        }
        const ImVec2 at{view_.corner.x + static_cast<float>(pixel->x_px),
                        view_.corner.y + static_cast<float>(pixel->y_px)};
        const float margin = 4.0F * scale_;
        const ImVec2 text = ImGui::CalcTextSize(caption.text.c_str());
        Rectangle box{{at.x - 0.5F * text.x - margin, at.y - text.y - 12.0F * scale_},
                      {text.x + 2.0F * margin, text.y + 0.5F * margin}};
        if (clear_ && overlap(*clear_, box)) { // to the side that it is on
            box.corner.x = at.x < clear_->corner.x + 0.5F * clear_->size.x
                               ? clear_->corner.x - box.size.x
                               : clear_->corner.x + clear_->size.x;
        }
        while (std::ranges::any_of(boxes_, [&](const Rectangle &b) { return overlap(b, box); })) {
            box.corner.y -= 0.5F * box.size.y;
        }
        boxes_.push_back(box);
        const ImVec2 end = box.end();
        const ImU32 ink = ImGui::ColorConvertFloat4ToU32(colour);
        list_.AddLine({std::clamp(at.x, box.corner.x, end.x), end.y}, at, ink, scale_);
        list_.AddRectFilled(box.corner, end, ImGui::ColorConvertFloat4ToU32(kCard), 3.0F * scale_);
        list_.AddText({box.corner.x + margin, box.corner.y + 0.25F * margin}, ink,
                      caption.text.c_str());
        ui::enter_at(box, caption.text, "caption", caption.text);
    }

private:
    const Camera &camera_;
    const Rectangle &view_;
    float scale_;
    ImDrawList &list_;
    std::vector<Rectangle> boxes_;
    std::optional<Rectangle> clear_;
};

} // namespace

float width_of_scene_card(const session::Session &session, const SceneCardState &state,
                          const Rectangle &view, float scale) {
    const bool is_new = state.scene != session.scenes().id();
    const bool is_shown =
        (is_new || !state.is_put_away) && !session.scenes().now().scene.lesson.is_empty();
    return is_shown ? card_margin(scale) + card_width(view, scale) : 0.0F;
}

void draw_scene_card(session::Session &session, TuningEditor &editor,
                     std::span<const std::filesystem::path> files, SceneCardState &state,
                     const Rectangle &place, float scale) {
    if (state.scene != session.scenes().id()) {
        state = {session.scenes().id(), false, {}};
    }
    measure(session, state);
    const scene::Lesson &lesson = session.scenes().now().scene.lesson;
    if (state.is_put_away || lesson.is_empty()) {
        return;
    }
    const ui::Scope scope("lesson");
    const float margin = card_margin(scale);
    const float width = card_width(place, scale);
    ImGui::SetNextWindowPos({place.corner.x + margin, place.corner.y + margin});
    ImGui::SetNextWindowSize({width, 0.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, kCard);
    ImGui::Begin("lesson", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                     ImGuiWindowFlags_NoBringToFrontOnFocus);
    draw_head(session, files, state);
    if (!lesson.feel.empty()) {
        ui::wrapped(kInk, "{}", lesson.feel);
    }
    if (lesson.spot) {
        draw_angles(session, editor, state);
    }
    ImGui::End();
    ImGui::PopStyleColor();
}

void draw_captions(const session::Session &session, const Camera &camera, const Rectangle &view,
                   float scale, const ArrowSize &arrow) {
    const scene::Scene &scene = session.scenes().now().scene;
    Captions captions(camera, view, scale);
    const servo::ServoSample &now = session.latest();
    captions.keep_clear(now.tip_m, now.tip_m + arrow.m_per_N * now.tip_force_N);
    for (const scene::Caption &caption : scene.captions) {
        captions.draw(caption, kInk);
    }
    if (scene.lesson.spot && !session.latest().contact.touching) {
        captions.draw({"press here", scene.lesson.spot->point_m}, kForce);
    }
}

} // namespace springdrive::app
