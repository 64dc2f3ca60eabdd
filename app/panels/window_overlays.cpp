#include "app/panels/scene_overlay.h"

#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "base/eigenvalues.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <system_error>

namespace springdrive::app {

namespace {

struct KeyHelp {
    const char *key;
    const char *what;
};

/// All keys of the window; those without Ctrl act while no text is typed, F12 always.
constexpr std::array<KeyHelp, 29> kKeys{{
    {"F12", "emergency stop, at any time; the space bar while no text is typed"},
    {"Ctrl+Z", "take the last change of the tuning back"},
    {"Ctrl+Y", "do it again; also Ctrl+Shift+Z"},
    {"Ctrl+S", "keep the session in a folder, or bring it up to date"},
    {"B", "switch between the tunings A and B"},
    {"M", "switch between the maps"},
    {"H", "hold the plots, or follow the present"},
    {"+ -, PgUp PgDn", "zoom the plots in time; move them to earlier or later"},
    {"P", "pause the simulated device, or go on; a record that is shown, too"},
    {". ,", "one tick of the paused device, or of the record: on, back"},
    {"R", "show the record that is open, or the present"},
    {"W A S D Q E", "move the hand: forward, left, back, right, down, up; with Shift finely"},
    {"I J K L U O", "turn the view: up, left, down, right; nearer, farther"},
    {"F6", "go to the next panel; with Shift, to the one before"},
    {"arrows, Tab", "go from widget to widget; Enter presses it, or begins to change it"},
    {"Home", "show the whole device and scene, also after the window has changed"},
    {"T F", "the same from above, from the front"},
    {"F9", "write a picture of the window, where sessions are kept"},
    {"F10", "hide the panels, or show them: scene and read-outs alone"},
    {"F11", "fill the screen"},
    {"Ctrl + − 0", "larger, smaller, usual text"},
    {"F1", "show or hide these keys"},
    {"Esc", "close what is open: this, a list, large plots, the full screen"},
    {"wheel on a plot", "zoom in time; with Ctrl, in value"},
    {"drag on a plot", "move; with the right button, zoom to the range"},
    {"double click on a plot", "live again, with its own ranges"},
    {"left press on the scene", "touch there; a drag slides on it, the wheel presses deeper"},
    {"left drag beside it", "move the hand, also with Shift; with the wheel, in depth"},
    {"right or middle drag", "turn or shift the view; the wheel zooms to the cursor"},
}};

struct StartLine {
    const char *about;
    const char *text;
};

/// Short enough for one line each in the smallest window; true of every scene.
constexpr std::array<StartLine, 3> kStartLines{{
    {"Simulated", "a PHANTOM with its motors, and a hand. No device is attached."},
    {"Move the hand", "press where it is to touch, drag to slide. Beside the scene: a free drag."},
    {"Try first", "press on the surface: the arrow is the force. M: the other map may tilt it."},
}};

struct MenuEntry {
    WindowOrder order;
    const char *label;
    const char *key;
};

constexpr std::array<MenuEntry, 9> kMenuEntries{{
    {WindowOrder::tour, "tour of the scenes", ""},
    {WindowOrder::toggle_panels, "hide or show the panels", "F10"},
    {WindowOrder::toggle_full_screen, "fill the screen", "F11"},
    {WindowOrder::larger_text, "larger text", "Ctrl +"},
    {WindowOrder::smaller_text, "smaller text", "Ctrl −"},
    {WindowOrder::usual_text, "usual text", "Ctrl 0"},
    {WindowOrder::take_picture, "picture of the window", "F9"},
    {WindowOrder::toggle_keys, "keys and mouse", "F1"},
    {WindowOrder::reset, "reset the settings", ""},
}};

void draw_recent(const Settings &settings, WindowMenuChoice &choice) {
    if (settings.recent.empty()) {
        return;
    }
    ImGui::Separator();
    ui::text(kFaintInk, "recent files");
    const ui::Scope scope("recent");
    for (const std::filesystem::path &file : settings.recent) {
        std::error_code ignored;
        const bool is_there = std::filesystem::exists(file, ignored);
        {
            const ui::Disabled gone(!is_there);
            const ui::Scope one(file.string());
            if (ui::selectable(file.filename().c_str(), false)) {
                choice.opened = file;
            }
        }
        ui::explain(file.string() + (is_there ? "" : "\nis not there any more"));
    }
}

/// The value of a channel where the record stands, or now; NaN where it has none.
double shown_value(const PlotSubject &subject, const char *channel) {
    const record::ChannelStore &store = subject.store;
    if (store.is_empty()) {
        return std::nan("");
    }
    const std::uint64_t last = store.end() - 1;
    const std::uint64_t row =
        subject.position_s ? std::min(last, store.row_at(*subject.position_s)) : last;
    return store.value(session::channel_named(channel).value(), row);
}

struct ReadOut {
    const char *name;
    std::string label;
    double value = 0.0;
    int decimals = 0;
    const char *unit;
    ImVec4 colour;
};

/// Digits, 0.626 of that, are 5 % of the view's height where its width allows.
float height_of_values(const Rectangle &view) {
    return std::min(0.08F * view.size.y, 0.06F * view.size.x);
}

/// The value large, below it what it is.
void show_read_out(const ReadOut &shown, ImFont *font, float digits_height) {
    const ui::Scope scope(shown.name);
    ImGui::TableNextColumn();
    {
        const ui::Sized sized(font, digits_height);
        ui::text(shown.colour, "{}",
                 std::isnan(shown.value)
                     ? "–"
                     : ui::formatted("{:.{}f}{}", shown.value, shown.decimals, shown.unit));
    }
    ui::text(kInk, "{}", shown.label);
}

ImU32 ink_of(const Colour &colour) {
    return ImGui::ColorConvertFloat4ToU32({colour[0], colour[1], colour[2], 1.0F});
}

/// One colour, two halves, or a scale.
void draw_swatch(const OverlayStyle &look) {
    const float height = ImGui::GetTextLineHeight();
    const ImVec2 size{1.8F * height, 0.62F * height};
    const ImVec2 place = ImGui::GetCursorScreenPos();
    const ImVec2 corner{place.x, place.y + 0.5F * (ImGui::GetFrameHeight() - size.y)};
    ImDrawList &list = *ImGui::GetWindowDrawList();
    constexpr int kParts = 6;
    for (int part = 0; part < kParts; ++part) {
        const auto at = [&](int edge) {
            return corner.x + size.x * static_cast<float>(edge) / static_cast<float>(kParts);
        };
        const auto share = [](int edge) { return static_cast<double>(edge) / kParts; };
        const Colour plain = part < kParts / 2 ? look.colour : look.second;
        const ImU32 left = ink_of(look.is_scale ? scale_colour(share(part)) : plain);
        const ImU32 right = ink_of(look.is_scale ? scale_colour(share(part + 1)) : plain);
        list.AddRectFilledMultiColor({at(part), corner.y}, {at(part + 1), corner.y + size.y}, left,
                                     right, right, left);
    }
    ImGui::Dummy({size.x, ImGui::GetFrameHeight()});
}

/// The numbers behind the colours, if there are any.
std::string range_of(Thing thing, const TouchValues &values) {
    constexpr double kPerMillimetre = 1e-3;
    switch (thing) {
    case Thing::trace:
        return ui::formatted("0 … {:.0f} N", kTraceEnd_N);
    case Thing::direction_errors:
        return !values.workspace
                   ? ""
                   : ui::formatted("0 … {:.0f}°", kDegreesPerRadian * values.workspace->largest);
    case Thing::stiffnesses:
        return !values.workspace
                   ? ""
                   : ui::formatted("0 … {:.1f} N/mm", kPerMillimetre * values.workspace->largest);
    case Thing::stiffness:
        if (values.inverse_stiffness_N_per_m && values.transpose_stiffness_N_per_m) {
            const Vector3 along_axes = symmetric_eigenvalues(*values.inverse_stiffness_N_per_m);
            return ui::formatted("{:.2f} · {:.2f} … {:.2f} N/mm",
                                 kPerMillimetre * *values.transpose_stiffness_N_per_m,
                                 kPerMillimetre * along_axes[0], kPerMillimetre * along_axes[2]);
        }
        return "";
    default:
        return "";
    }
}

void draw_row(ShownThings &shown, const OverlayStyle &look, const TouchValues &values) {
    draw_swatch(look);
    ImGui::SameLine();
    bool is_on = shown.shows(look.thing);
    if (ui::checkbox(look.label, is_on)) {
        shown.show(look.thing, is_on);
    }
    ui::explain(look.help);
    if (const std::string range = is_on ? range_of(look.thing, values) : ""; !range.empty()) {
        const ui::Scope scope(look.word);
        ImGui::Indent(2.6F * ImGui::GetTextLineHeight());
        ui::text(kFaintInk, "{}", range);
        ImGui::Unindent(2.6F * ImGui::GetTextLineHeight());
    }
}

} // namespace

void draw_keys_overlay(const Rectangle &window) {
    const float font = ImGui::GetFontSize();
    const ui::Scope scope("keys");
    ImGui::SetNextWindowPos(
        {window.corner.x + 0.5F * window.size.x, window.corner.y + 0.5F * window.size.y},
        ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::Begin("keys", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings);
    ui::text(kInk, "Keys and mouse");
    ImGui::Separator();
    for (const KeyHelp &help : kKeys) {
        ui::text(kForce, "{}", help.key);
        ImGui::SameLine(12.0F * font);
        ui::text(kInk, "{}", help.what);
    }
    ImGui::End();
}

StartAnswer draw_start_card(const Rectangle &place, float &height) {
    StartAnswer answer = StartAnswer::none;
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.10F, 0.20F, 0.36F, 1.0F));
    {
        const ui::Panel panel("Start", place,
                              ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoScrollbar |
                                  ImGuiWindowFlags_NoFocusOnAppearing);
        const float texts_at = 8.0F * ImGui::GetFontSize();
        for (const StartLine &line : kStartLines) {
            ui::text(kForce, "{}", line.about);
            ImGui::SameLine(texts_at);
            ui::wrapped(kInk, "{}", line.text);
        }
        if (ui::button("got it")) {
            answer = StartAnswer::got_it;
        }
        ui::explain("does not show this again; reset the settings in the menu \u2261 to see it");
        ImGui::SameLine();
        if (ui::button("keys  F1")) {
            answer = StartAnswer::keys;
        }
        ImGui::SameLine();
        if (ui::button("the wrong direction")) {
            answer = StartAnswer::wrong_direction;
        }
        ui::explain("Shows the scene in which M tilts it most: press on the orange square there.");
        height = ImGui::GetCursorPosY() - ImGui::GetStyle().ItemSpacing.y +
                 ImGui::GetStyle().WindowPadding.y;
    }
    ImGui::PopStyleColor();
    return answer;
}

WindowMenuChoice draw_window_menu(const WindowHabits &habits, const Rectangle &view, float scale) {
    WindowMenuChoice choice;
    const float margin = 10.0F * scale;
    const ui::Scope scope("window");
    ImGui::SetNextWindowPos({view.corner.x + margin, view.corner.y + margin});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::Begin("window", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBackground |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize);
    const float side = 2.0F * ImGui::GetFontSize();
    const bool is_pressed = ui::button("≡##menu", {side, side});
    ui::explain("the window: text, panels, full screen, pictures, recent files");
    ImGui::PopStyleVar(2);
    if (is_pressed) {
        ImGui::OpenPopup("menu");
    }
    if (ImGui::BeginPopup("menu")) {
        const float keys_at = 14.0F * ImGui::GetFontSize();
        for (const MenuEntry &entry : kMenuEntries) {
            const bool forgets = entry.order == WindowOrder::reset;
            if (forgets && !habits.remembers()) {
                continue;
            }
            if (ui::selectable(entry.label, false)) {
                choice.order = entry.order;
            }
            if (forgets) {
                ui::explain("size and text of the window, panels, recent files and the first "
                            "minute's plate:\nall as in a first run");
            }
            if (*entry.key != '\0') {
                ImGui::SameLine(keys_at);
                ui::text(kFaintInk, "{}", entry.key);
            }
        }
        draw_recent(habits.settings(), choice);
        ImGui::EndPopup();
    }
    ImGui::End();
    return choice;
}

float height_of_read_outs(const Rectangle &view) {
    const ImGuiStyle &style = ImGui::GetStyle();
    return height_of_values(view) + ImGui::GetTextLineHeight() + style.ItemSpacing.y +
           2.0F * (style.WindowPadding.y + style.CellPadding.y);
}

void draw_read_outs(const PlotSubject &subject, control::MotionMap map, const Rectangle &view,
                    const Window::LargeText &text, float scale) {
    const float margin = 10.0F * scale;
    const ui::Scope scope("read-outs");
    ImGui::SetNextWindowPos({view.corner.x + margin, view.end().y - 3.0F * margin},
                            ImGuiCond_Always, {0.0F, 1.0F});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.10F, 0.11F, 0.13F, 0.92F));
    ImGui::Begin("read-outs", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize);
    const bool transposes = map == control::MotionMap::transpose;
    const std::array<ReadOut, 3> shown{{
        {"force", "force", shown_value(subject, "force_N"), 2, " N", kForce},
        {"angle", ui::formatted("off the normal, {}", control::label_of(map)),
         kDegreesPerRadian *
             shown_value(subject, transposes ? "transpose_measured_rad" : "inverse_measured_rad"),
         0, "°", transposes ? kTransposeMap : kInverseMap},
        {"depth", "depth", 1e3 * shown_value(subject, "penetration_m"), 1, " mm", kInk},
    }};
    const float height = height_of_values(view);
    constexpr float kWidth = 4.0F; // of "12.34 mm", by its height
    if (ImGui::BeginTable("values", static_cast<int>(shown.size()),
                          ImGuiTableFlags_SizingFixedFit)) {
        for (const ReadOut &each : shown) { // as wide as the widest value, so that none moves
            ImGui::TableSetupColumn(
                each.name, ImGuiTableColumnFlags_WidthFixed,
                std::max(kWidth * height, ImGui::CalcTextSize(each.label.c_str()).x));
        }
        for (const ReadOut &each : shown) {
            show_read_out(each, text.large, height);
        }
        ImGui::EndTable();
    }
    ImGui::End();
    ImGui::PopStyleColor();
}

float draw_legend(ShownThings &shown, bool &is_open, const TouchValues &values,
                  const Rectangle &view, float top, float width, float scale) {
    const float margin = 10.0F * scale;
    const ui::Scope scope("legend");
    ImGui::SetNextWindowPos({view.end().x - margin, top}, ImGuiCond_Always, {1.0F, 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0F);
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.07F, 0.08F, 0.10F, 0.92F));
    const ImVec2 padding = ImGui::GetStyle().WindowPadding;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, is_open ? padding : ImVec2(0.0F, 0.0F));
    ImGui::Begin("legend", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_AlwaysAutoResize |
                     (is_open ? 0 : ImGuiWindowFlags_NoBackground));
    if (!is_open) {
        is_open = ui::button("legend", {width, 0.0F});
        ui::explain("Names what is drawn in the scene, and switches it.");
    } else {
        ui::text(kForce, "what is drawn");
        ImGui::SameLine(12.0F * ImGui::GetFontSize());
        is_open = !ui::small_button("×##fold");
        ui::explain("Folds the legend; what is switched on stays.");
        ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing,
                            {ImGui::GetStyle().ItemSpacing.x, 1.0F * scale});
        ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {2.0F * scale, 1.0F * scale});
        for (const OverlayStyle &look : kThings) {
            draw_row(shown, look, values);
        }
        ImGui::PopStyleVar(2);
    }
    const float card_width = is_open ? ImGui::GetWindowWidth() : 0.0F;
    ImGui::End();
    ImGui::PopStyleVar(2);
    ImGui::PopStyleColor();
    return card_width;
}

} // namespace springdrive::app
