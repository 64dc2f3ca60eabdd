#include "app/exhibit/kiosk.h"

#include "app/widgets/widgets.h"
#include "base/degrees.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::app::exhibit {

namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

const ImVec4 kBackdrop{0.07F, 0.08F, 0.10F, 0.86F};
const ImVec4 kBare{0.0F, 0.0F, 0.0F, 0.0F};

// Heights of text and places, in units of the picture, which is 1280 × 720 of them.
constexpr float kDigits = 78.0F; // digits of the font are 0.626 times as high
constexpr float kHeading = 40.0F;
constexpr float kBody = 24.0F;
constexpr float kMargin = 16.0F;
constexpr float kTop = 128.0F;
constexpr float kBottom = 124.0F;
constexpr float kButton = 72.0F;
constexpr float kWide = 760.0F; // of the lesson, and of a condition, which takes its place

float unit_of(const Rectangle &view) {
    return std::min(view.size.x / 1280.0F, view.size.y / 720.0F);
}

/// A plate for the scope's widgets; with `wide` 0 as wide as they are.
class Card {
public:
    Card(const char *name, ImVec2 corner, ImVec2 pivot, float wide, const ImVec4 &colour,
         ImGuiWindowFlags flags = 0)
        : scope_(name) {
        ImGui::SetNextWindowPos(corner, ImGuiCond_Always, pivot);
        if (wide > 0.0F) {
            ImGui::SetNextWindowSize({wide, 0.0F});
        }
        ImGui::PushStyleColor(ImGuiCol_WindowBg, colour);
        ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
        ImGui::Begin(name, nullptr,
                     kPlain | flags | (wide > 0.0F ? 0 : ImGuiWindowFlags_AlwaysAutoResize));
    }
    ~Card() {
        ImGui::End();
        ImGui::PopStyleVar();
        ImGui::PopStyleColor();
    }
    Card(const Card &) = delete;
    Card &operator=(const Card &) = delete;

private:
    ui::Scope scope_;
};

class KioskPicture {
public:
    KioskPicture(const KioskShown &shown, const Camera &camera, const Rectangle &view,
                 const Window::LargeText &text)
        : shown_(shown), camera_(camera), view_(view), text_(text), u_(unit_of(view)) {}

    KioskAnswer draw() {
        draw_lesson();
        draw_stop();
        draw_banner();
        if (shown_.course.stage() != Stage::attract) {
            draw_choices();
        }
        draw_read_out();
        draw_condition();
        return answer_;
    }

private:
    [[nodiscard]] float left() const { return view_.corner.x + kMargin * u_; }
    [[nodiscard]] float right() const { return view_.corner.x + view_.size.x - kMargin * u_; }
    [[nodiscard]] float top() const { return view_.corner.y + kMargin * u_; }
    [[nodiscard]] float bottom() const { return view_.corner.y + view_.size.y - kMargin * u_; }
    [[nodiscard]] float middle() const { return view_.corner.x + 0.5F * view_.size.x; }

    bool button(const char *label, float width, float height = kButton) const {
        const ui::Sized sized(text_.medium, 1.1F * kBody * u_);
        return ui::button(label, {width * u_, height * u_});
    }

    void draw_lesson() const {
        if (shown_.title.empty() || words()) { // while the scene is loaded, or has to wait
            return;
        }
        const Card card("lesson", {left(), top()}, {0.0F, 0.0F}, kWide * u_, kBackdrop,
                        ImGuiWindowFlags_NoInputs);
        {
            const ui::Sized sized(text_.medium, kHeading * u_);
            ui::text(kForce, "{}", shown_.title);
        }
        const ui::Sized sized(text_.medium, kBody * u_);
        ui::wrapped(kInk, "{}", shown_.sentence);
    }

    void draw_stop() {
        ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
        ImGui::PushStyleColor(ImGuiCol_Button, ImVec4(0.66F, 0.12F, 0.10F, 1.0F));
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ImVec4(0.80F, 0.17F, 0.14F, 1.0F));
        ImGui::PushStyleColor(ImGuiCol_ButtonActive, ImVec4(0.92F, 0.24F, 0.20F, 1.0F));
        {
            const Card card("stop", {right(), top()}, {1.0F, 0.0F}, 0.0F, kBare);
            answer_.stop = button("STOP  F12##stop", 190.0F, 84.0F);
        }
        ImGui::PopStyleColor(3);
        ImGui::PopStyleVar();
    }

    [[nodiscard]] const char *banner() const {
        switch (shown_.course.stage()) {
        case Stage::attract:
            return shown_.has_script ? "Touch to begin" : "Take the pen";
        case Stage::showing:
            return "Watch";
        case Stage::your_turn:
            break;
        }
        return "Your turn";
    }

    [[nodiscard]] const char *below_banner() const {
        if (shown_.course.stage() == Stage::showing) {
            return shown_.has_script ? "what the hand does" : "what there is to feel";
        }
        return shown_.has_script ? "press on the scene, drag to slide" : "take the pen and touch";
    }

    void draw_banner() {
        const bool is_attract = shown_.course.stage() == Stage::attract;
        const ImVec2 corner = is_attract ? ImVec2{middle(), bottom()} : ImVec2{left(), bottom()};
        const Card card("stage", corner, {is_attract ? 0.5F : 0.0F, 1.0F}, 0.0F, kBackdrop,
                        ImGuiWindowFlags_NoInputs);
        {
            const ui::Sized sized(is_attract ? text_.large : text_.medium,
                                  (is_attract ? kDigits : kHeading) * u_);
            ui::text(kForce, "{}", banner());
        }
        if (!is_attract) {
            const ui::Sized sized(text_.medium, kBody * u_);
            ui::text(kInk, "{}", below_banner());
        }
    }

    void draw_choices() {
        ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
        {
            const Card card("choices", {right(), bottom()}, {1.0F, 1.0F}, 0.0F, kBare);
            if (shown_.course.stage() == Stage::showing) {
                answer_.my_turn = button("my turn", 170.0F);
                ImGui::SameLine();
            }
            if (shown_.course.stage() ==
                Stage::your_turn) { // while it is shown, the hand switches it
                const bool transposes = shown_.map == control::MotionMap::transpose;
                ImGui::PushStyleColor(ImGuiCol_Text, transposes ? kTransposeMap : kInverseMap);
                answer_.other_map = button(transposes ? "map: transpose  (M)###other map"
                                                      : "map: inverse  (M)###other map",
                                           270.0F);
                ImGui::PopStyleColor();
                ImGui::SameLine();
            }
            answer_.next_scene = button("next scene", 190.0F);
            ImGui::SameLine();
            answer_.next_visitor = button("next visitor", 200.0F);
        }
        ImGui::PopStyleVar();
    }

    /// To the right of the arrow's end and above it, where it covers nothing that is touched.
    void draw_read_out() const {
        if (!shown_.read_out) {
            return;
        }
        const KioskReadOut &values = *shown_.read_out;
        const ImVec2 size{430.0F * u_, 138.0F * u_};
        const Rectangle free = free_in_kiosk(view_);
        ImVec2 corner = free.corner;
        report_arrow(values);
        if (const auto end = camera_.pixel_of(values.arrow_m, {view_.size.x, view_.size.y})) {
            const float gap = 30.0F * u_;
            corner = {view_.corner.x + static_cast<float>(end->x_px) + gap,
                      view_.corner.y + static_cast<float>(end->y_px) - gap - size.y};
        }
        corner.x = std::clamp(corner.x, free.corner.x, free.corner.x + free.size.x - size.x);
        corner.y = std::clamp(corner.y, free.corner.y, free.corner.y + free.size.y - size.y);
        const bool transposes = shown_.map == control::MotionMap::transpose;
        const ImVec4 &colour = transposes ? kTransposeMap : kInverseMap;
        const Card card("read-outs", corner, {0.0F, 0.0F}, size.x, kBackdrop,
                        ImGuiWindowFlags_NoInputs);
        if (!ImGui::BeginTable("values", 2)) {
            return;
        }
        ImGui::TableSetupColumn("force", ImGuiTableColumnFlags_WidthFixed, 215.0F * u_);
        ImGui::TableNextColumn();
        draw_value("force", "force", kForce, ui::formatted("{:.1f} N", values.force_N));
        ImGui::TableNextColumn();
        draw_value("angle", transposes ? "off square, transpose" : "off square, inverse", colour,
                   values.angle_rad
                       ? ui::formatted("{:.0f}°", kDegreesPerRadian * *values.angle_rad)
                       : "–");
        ImGui::EndTable();
    }

    /// Its box in the picture: drawn with the scene, it is no widget.
    void report_arrow(const KioskReadOut &values) const {
        const auto from = camera_.pixel_of(values.arrow_from_m, {view_.size.x, view_.size.y});
        const auto to = camera_.pixel_of(values.arrow_m, {view_.size.x, view_.size.y});
        if (from && to) {
            const auto left = static_cast<float>(std::min(from->x_px, to->x_px));
            const auto top = static_cast<float>(std::min(from->y_px, to->y_px));
            ui::enter_at({{view_.corner.x + left, view_.corner.y + top},
                          {static_cast<float>(std::abs(to->x_px - from->x_px)),
                           static_cast<float>(std::abs(to->y_px - from->y_px))}},
                         "marks/arrow", "mark", "the force");
        }
    }

    void draw_value(const char *name, const char *label, const ImVec4 &colour,
                    const std::string &value) const {
        {
            const ui::Scope scope(name);
            const ui::Sized sized(text_.large, kDigits * u_);
            ui::text(colour, "{}", value);
        }
        const ui::Sized sized(text_.medium, 0.8F * kBody * u_);
        ui::text(kInk, "{}", label);
    }

    struct Words {
        std::string first;
        std::string second;
        ImVec4 colour{0.36F, 0.26F, 0.05F, 0.97F};
    };

    [[nodiscard]] std::optional<Words> words() const {
        const ImVec4 kRed{0.42F, 0.09F, 0.08F, 0.97F};
        switch (shown_.recovery.condition()) {
        case Condition::lost:
            return Words{"The device is not connected.",
                         "Once it is plugged in again, it asks whether it may go on.", kRed};
        case Condition::let_go:
            return Words{"Stopped: let go, please.", shown_.stop, kRed};
        case Condition::pause:
            return Words{ui::formatted("Stopped. It goes on in {:.0f} s.",
                                       std::ceil(shown_.recovery.goes_on_in_s())),
                         shown_.stop, kRed};
        case Condition::asks_go_on:
            return Words{"Stopped. Is nobody in its way?", shown_.stop, kRed};
        case Condition::lift:
            return Words{"Lift the tip off the surface.", "Then the motors start."};
        case Condition::needs_staff:
            return Words{"Please call the staff.",
                         shown_.stop.empty() ? "The device failed its test." : shown_.stop, kRed};
        case Condition::needs_zeroing:
            return Words{"Please call the staff.",
                         "The board does not know where the device is: upper arm level, forearm "
                         "hanging, then Ctrl+Alt+Z."};
        case Condition::well:
            break;
        }
        if (const auto leaves_in_s = shown_.course.leaves_in_s()) {
            return Words{"Still there?",
                         ui::formatted("Touch anything, or the show begins again in {:.0f} s.",
                                       std::ceil(*leaves_in_s)),
                         {0.10F, 0.20F, 0.36F, 0.97F}};
        }
        return std::nullopt;
    }

    void draw_condition() {
        const std::optional<Words> said = words();
        if (!said) {
            return;
        }
        const Card card("condition", {left(), top()}, {0.0F, 0.0F}, kWide * u_, said->colour);
        {
            const ui::Sized sized(text_.medium, kHeading * u_);
            ui::wrapped(kInk, "{}", said->first);
        }
        {
            const ui::Sized sized(text_.medium, kBody * u_);
            ui::wrapped(kInk, "{}", said->second);
        }
        answer_.go_on =
            shown_.recovery.condition() == Condition::asks_go_on && button("go on", 200.0F);
    }

    const KioskShown &shown_;
    const Camera &camera_;
    Rectangle view_;
    Window::LargeText text_;
    float u_;
    KioskAnswer answer_;
};

} // namespace

KioskAnswer draw_kiosk(const KioskShown &shown, const Camera &camera, const Rectangle &view,
                       const Window::LargeText &text) {
    return KioskPicture(shown, camera, view, text).draw();
}

Rectangle free_in_kiosk(const Rectangle &view) {
    const float u = unit_of(view);
    return {{view.corner.x + kMargin * u, view.corner.y + kTop * u},
            {view.size.x - 2.0F * kMargin * u, view.size.y - (kTop + kBottom) * u}};
}

} // namespace springdrive::app::exhibit
