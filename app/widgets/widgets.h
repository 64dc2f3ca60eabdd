// The widgets of all panels: Dear ImGui's, each of which also enters what it shows into the
// window's report. Panels use these instead of ImGui's own.
//
// An item's id in the report is the path of its scopes and its label: "Tuning/Gains/K_P/slider". Of
// a label like "##slider" or "×##close" the part behind the marks counts, of which ImGui shows
// none. A label that changes needs three marks, "stop###play": for ImGui only the part behind them
// is then the item.
#pragma once

#include "app/widgets/rectangle.h"
#include "app/window/window.h"
#include "base/print.h"
#include "engine/servo/servo_sample.h"
#include "engine/servo/servo_timing.h"

#include <imgui.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::app {

// Colours and spacing of the whole window.

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

// What the window shows, as data: every widget with its place, text and value, for tests and
// scripts.
//
//   widgets ──► enter() ──► WindowReport ──► json_line(), one line, on request

/// One widget in one frame.
struct ShownItem {
    std::string id;   ///< panel, scopes and label, from outside in: "Tuning/Gains/K_P/slider"
    std::string kind; ///< "button", "text", "slider", …
    std::string text; ///< as shown
    std::variant<std::monostate, bool, double, std::string> value;
    std::vector<std::pair<std::string, double>> numbers; ///< further ones, for example of a plot
    Rectangle place;        ///< in the window's units; what is seen of it
    bool is_visible = true; ///< not scrolled out of its panel
    bool is_enabled = true;
    bool is_focused = false; ///< keys act on it
    bool overflows = false;  ///< wider than its panel
};

/// Collects the items of a frame, if they are wanted.
class WindowReport {
public:
    /// Begins a frame.
    void begin(bool is_requested) {
        is_requested_ = is_requested;
        items_.clear();
    }
    [[nodiscard]] bool is_requested() const { return is_requested_; }

    void enter(ShownItem item) { items_.push_back(std::move(item)); }
    void note_focus() { items_.back().is_focused = true; } ///< on the last one
    [[nodiscard]] const std::vector<ShownItem> &items() const { return items_; }

private:
    bool is_requested_ = false;
    std::vector<ShownItem> items_;
};

/// The window itself, beside its items.
struct WindowFacts {
    std::uint64_t frame = 0;
    float width = 0.0F;
    float height = 0.0F;
    float scale = 1.0F;
    double frame_median_s = 0.0; ///< time to compute and draw a frame
    double frame_p99_s = 0.0;
};

/// @param durations  of its frames
[[nodiscard]] WindowFacts facts_of(std::uint64_t frame, int width, int height, float scale,
                                   const servo::DurationHistogram &durations);

/// One line of JSON: `window`, `items`, and `sample`, the servo's latest sample by telemetry
/// column.
[[nodiscard]] std::string json_line(const WindowReport &report, const WindowFacts &window,
                                    const servo::ServoSample &sample);

namespace ui {

/// The report of the current frame; like ImGui's context there is one, for the window's thread.
[[nodiscard]] WindowReport &report();

/// Enters the previous item of ImGui. For widgets that are drawn elsewhere, such as plots.
/// @param numbers  further values, if any
void enter(std::string_view label, const char *kind, std::string_view text,
           decltype(ShownItem::value) value = {}, decltype(ShownItem::numbers) numbers = {});

/// Enters something that is no item of ImGui, such as text drawn over the scene.
void enter_at(const Rectangle &place, std::string_view label, const char *kind,
              std::string_view text);

/// Widgets until the end of this scope belong to `name`: in their ids, and for ImGui.
class Scope {
public:
    explicit Scope(std::string_view name);
    ~Scope();
    Scope(const Scope &) = delete;
    Scope &operator=(const Scope &) = delete;
};

/// Text of that height [px] until the end of the scope; `font` is the one nearest to it.
class Sized {
public:
    Sized(ImFont *font, float height);
    ~Sized();
    Sized(const Sized &) = delete;
    Sized &operator=(const Sized &) = delete;
};

/// A panel, at its fixed place.
class Panel {
public:
    /// @param flags  in addition to those of a fixed place
    Panel(const char *title, const Rectangle &place, ImGuiWindowFlags flags = 0);
    ~Panel();
    Panel(const Panel &) = delete;
    Panel &operator=(const Panel &) = delete;

private:
    Scope scope_;
};

/// A row of tabs; pairs with `Tab`.
class Tabs {
public:
    explicit Tabs(const char *id) : is_open_(ImGui::BeginTabBar(id)) {}
    ~Tabs() {
        if (is_open_) {
            ImGui::EndTabBar();
        }
    }
    Tabs(const Tabs &) = delete;
    Tabs &operator=(const Tabs &) = delete;
    [[nodiscard]] explicit operator bool() const { return is_open_; }

private:
    bool is_open_;
};

/// A tab; its contents are drawn only while it is the open one.
class Tab {
public:
    explicit Tab(const char *label);
    ~Tab();
    Tab(const Tab &) = delete;
    Tab &operator=(const Tab &) = delete;
    [[nodiscard]] explicit operator bool() const { return is_open_; }

private:
    bool is_open_;
};

/// Widgets until the end of this scope are grey and do nothing, if `is_disabled`.
class Disabled {
public:
    explicit Disabled(bool is_disabled);
    ~Disabled();
    Disabled(const Disabled &) = delete;
    Disabled &operator=(const Disabled &) = delete;

private:
    bool before_;
};

void show_text(const ImVec4 &colour, const std::string &text, bool wraps);

/// Formatted as by `print`, see base/print.h.
template <typename... Values>
[[nodiscard]] std::string formatted(CheckedFormat<std::type_identity_t<Values>...> format,
                                    const Values &...values) {
    return fmt::vformat(format.text(), fmt::make_format_args(values...));
}

template <typename... Values>
void text(const ImVec4 &colour, CheckedFormat<std::type_identity_t<Values>...> format,
          const Values &...values) {
    show_text(colour, fmt::vformat(format.text(), fmt::make_format_args(values...)), false);
}

/// Broken into lines at the panel's edge.
template <typename... Values>
void wrapped(const ImVec4 &colour, CheckedFormat<std::type_identity_t<Values>...> format,
             const Values &...values) {
    show_text(colour, fmt::vformat(format.text(), fmt::make_format_args(values...)), true);
}

/// In the colour of danger; nothing if it is empty.
inline void show_error(const std::string &error) {
    if (!error.empty()) {
        show_text(kDanger, error, true);
    }
}

/// The tooltip of the previous item, also of one that is disabled.
void explain(std::string_view text);

/// What is drawn until the end of this scope is a row: its text appears wherever the mouse rests on
/// the row, unless an item there explains itself, or something is being dragged.
class ExplainedRow {
public:
    /// How far a row reaches.
    enum class Reach : std::uint8_t { panel, items };

    /// @param text   broken into lines where it is long
    /// @param reach  `panel`: over its whole width; `items`: up to the last item, as in tables
    explicit ExplainedRow(std::string text, Reach reach = Reach::panel);
    ~ExplainedRow();
    ExplainedRow(const ExplainedRow &) = delete;
    ExplainedRow &operator=(const ExplainedRow &) = delete;

private:
    std::string text_;
    Reach reach_;
    ImVec2 corner_;
    std::size_t explained_before_;
};

/// True when pressed. @param size  0: as its label
bool button(const char *label, ImVec2 size = {0.0F, 0.0F});
bool small_button(const char *label);
bool tab_button(const char *label); ///< at the right end of a row of tabs

/// True when changed.
bool checkbox(const char *label, bool &value);

/// Whether a number was being typed in the last frame, for which the space bar is no letter.
[[nodiscard]] bool types_number();

/// A slider without a number. True when changed. @param shown  in the report
bool slider(const char *label, double &value, double minimum, double maximum, bool is_logarithmic);

// A number is typed as text, in which every key shows; it is complete on Enter or when the field
// loses focus. Escape, or an empty field, leaves the value. A comma is a decimal point. Text that
// is no number as a whole, or out of range, is refused: the value stays, and the field says why.

/// What may be typed, and its name for messages.
struct NumberRange {
    std::string_view name{};
    double minimum = -std::numeric_limits<double>::infinity();
    double maximum = std::numeric_limits<double>::infinity();
    std::string_view unit{};
};

/// A slider with its number on it, which can be typed after a click with Ctrl. True when changed.
/// @param format  of printf, for ImGui
bool slider_with_number(const char *label, double &value, double minimum, double maximum,
                        const char *format);

/// A number to be typed. True when `value` was set. @param format  of printf, for ImGui
bool number_field(const char *label, double &value, const char *format,
                  const NumberRange &range = {});

/// A line of text to be typed; `hint` is shown while it is empty. True on Enter.
bool text_field(const char *label, const char *hint, std::string &text);

/// Several lines of text to be typed. True when changed.
bool text_box(const char *label, std::string &text, ImVec2 size);

/// An entry of a list or menu. True when clicked.
bool selectable(const char *label, bool is_selected);

/// A list that drops down; its entries are drawn only while it is open.
class DropDown {
public:
    /// @param shown  while it is closed. The width is that of ImGui's next item.
    DropDown(const char *label, const char *shown);
    ~DropDown();
    DropDown(const DropDown &) = delete;
    DropDown &operator=(const DropDown &) = delete;
    [[nodiscard]] explicit operator bool() const { return is_open_; }

private:
    bool is_open_ = false;
};

/// One of several, in a list that drops down. True when changed. The width is that of ImGui's next
/// item.
bool choice(const char *label, std::size_t &index, std::span<const char *const> labels);

template <typename Enum, std::size_t count>
bool choice(const char *label, Enum &value, const std::array<const char *, count> &labels) {
    auto index = static_cast<std::size_t>(value);
    const bool is_changed = choice(label, index, std::span<const char *const>(labels));
    value = static_cast<Enum>(index);
    return is_changed;
}

void progress(const char *label, double share, const std::string &text);

} // namespace ui

} // namespace springdrive::app
