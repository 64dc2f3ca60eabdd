#include "app/study/participant/participant_layout.h"

#include "base/assertions.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kMostHeading = 1.0 / 13.0; // of the height, as all below
constexpr double kMostText = 1.0 / 22.0;
constexpr double kMargin = 1.0 / 16.0;
constexpr double kColumn = 1.25;    // width of text: some 60 letters a line
constexpr double kWideColumn = 1.6; // of headings and choices
constexpr double kWidestPlate = 0.62;
constexpr double kBar = 1.0 / 45.0; // height of what is left of a break
constexpr double kProgress = 1.0 / 180.0;
constexpr double kSceneTop = 0.2;
constexpr double kSceneBottom = 0.72;

constexpr std::size_t kHeadingLines = 2;
constexpr std::size_t kFieldLines = 4;
constexpr int kSteps = 12;        // from the largest to the least size
constexpr double kFurther = 0.94; // a step below the least
constexpr double kSmallest_px = 2.0;

int rounded_px(double length) { return static_cast<int>(std::lround(length)); }

/// Sizes of text [px], whole ones, and what is given up for them.
struct Attempt {
    double heading_px;
    double text_px;
    bool is_strict; ///< no word is broken, and a heading has two lines at most
};

/// Something of a height in a column.
struct Part {
    int height;
    int gap; ///< to what is above
    std::function<void(int top)> place;
};

class Composition {
public:
    Composition(const ParticipantPicture &picture, int width, int height, const Typeface &typeface,
                const Attempt &attempt)
        : picture_(picture), width_(width), height_(height), typeface_(typeface), attempt_(attempt),
          margin_(rounded_px(kMargin * height)),
          column_(std::min(width - 2 * margin_, rounded_px(kColumn * height))),
          wide_(std::min(width - 2 * margin_, rounded_px(kWideColumn * height))),
          gap_(rounded_px(0.9 * attempt.text_px)) {}

    /// Nothing if it does not fit.
    std::optional<ParticipantLayout> composed() {
        if (column_ < 4.0 * attempt_.text_px) {
            return std::nullopt;
        }
        const int bottom = place_foot();
        const std::vector<Part> upper = words();
        std::vector<Part> lower = answers();
        if (picture_.scene == SceneShown::scene || picture_.curve) {
            const int scene_top = rounded_px(kSceneTop * height_);
            const int scene_bottom = rounded_px(kSceneBottom * height_);
            if (picture_.curve) {
                layout_.curve =
                    arranged(*picture_.curve,
                             {(width_ - column_) / 2, scene_top, column_, scene_bottom - scene_top},
                             small_text_px(), typeface_);
            } else {
                layout_.scene = {0, scene_top, width_, scene_bottom - scene_top};
            }
            fits_ = fits_ && place(upper, margin_ / 2, scene_top - gap_ / 2) &&
                    place(lower, scene_bottom + gap_ / 2, bottom);
        } else {
            lower.insert(lower.begin(), upper.begin(), upper.end());
            fits_ = fits_ && place(lower, margin_, bottom);
        }
        return fits_ ? std::optional(std::move(layout_)) : std::nullopt;
    }

private:
    [[nodiscard]] TextLines lines(const std::string &text, double size_px, int most_width,
                                  TextAlign align = TextAlign::centre) {
        TextLines made = wrapped(text, typeface_, size_px, most_width, align);
        fits_ = fits_ && !(attempt_.is_strict && made.breaks_words);
        return made;
    }

    [[nodiscard]] PlacedText centred(TextLines text, int top) const {
        const int wide = text.width_px;
        const int high = text.height_px();
        return {{(width_ - wide) / 2, top, wide, high}, std::move(text)};
    }

    [[nodiscard]] double small_text_px() const {
        return std::min(attempt_.text_px, std::round(1.05 * kLeastTextPerHeight * height_));
    }

    /// Footer and progress. @return where everything else must end
    int place_foot() {
        int bottom = height_ - margin_ / 2;
        if (picture_.progress) {
            const int high = std::max(3, rounded_px(kProgress * height_));
            layout_.progress = {margin_, bottom - high, width_ - 2 * margin_, high};
            bottom -= high + margin_ / 4;
        }
        if (!picture_.footer.empty()) {
            TextLines text = lines(picture_.footer, small_text_px(), width_ - 2 * margin_);
            bottom -= text.height_px();
            layout_.footer = centred(std::move(text), bottom);
        }
        return bottom - gap_ / 2;
    }

    /// Heading and text.
    std::vector<Part> words() {
        std::vector<Part> parts;
        const int plate = picture_.is_calm_stop ? gap_ : 0;
        if (!picture_.heading.empty()) {
            TextLines heading = lines(picture_.heading, attempt_.heading_px, wide_ - 2 * plate);
            fits_ = fits_ && !(attempt_.is_strict && heading.lines.size() > kHeadingLines);
            parts.push_back({heading.height_px(), plate, [this, heading](int top) {
                                 layout_.heading = centred(heading, top);
                             }});
        }
        if (!picture_.text.empty()) {
            TextLines text = body(column_ - 2 * plate);
            parts.push_back({text.height_px(), parts.empty() ? plate : 3 * gap_ / 4,
                             [this, text](int top) { layout_.text = centred(text, top); }});
        }
        if (plate > 0 && !parts.empty()) { // lies behind the parts before it
            parts.push_back({plate, 0, [this, plate](int top) { lay_plate(top + plate, plate); }});
        }
        return parts;
    }

    /// In the middle where it is short, else flush left.
    TextLines body(int most_width) {
        TextLines text = lines(picture_.text, attempt_.text_px, most_width, TextAlign::left);
        if (text.lines.size() <= 2 || picture_.is_calm_stop) {
            text = lines(picture_.text, attempt_.text_px, most_width);
        }
        text.paragraph_gap_px = text.line_height_px / 2;
        return text;
    }

    void lay_plate(int bottom, int padding) {
        const PixelBox &heading = layout_.heading.box;
        const PixelBox &text = layout_.text.box;
        const int top = (heading.is_empty() ? text.y : heading.y) - padding;
        const int wide = std::max({heading.width, text.width}) + 4 * padding;
        const int fitting = std::min(wide, width_ - 2 * margin_);
        layout_.calm_plate = {(width_ - fitting) / 2, top, fitting, bottom - top};
    }

    /// What is left of a break, a free text, choices.
    std::vector<Part> answers() {
        std::vector<Part> parts;
        if (picture_.left_share) {
            const int high = std::max(4, rounded_px(kBar * height_));
            const int wide = std::min(column_, rounded_px(0.8 * height_));
            parts.push_back({high, gap_, [this, wide, high](int top) {
                                 layout_.left_bar = {(width_ - wide) / 2, top, wide, high};
                             }});
        }
        if (!picture_.left_text.empty()) {
            TextLines text = lines(picture_.left_text, attempt_.text_px, column_);
            parts.push_back({text.height_px(), gap_ / 2,
                             [this, text](int top) { layout_.left_text = centred(text, top); }});
        }
        if (picture_.has_text_field) {
            add_field(parts);
        }
        if (!picture_.choices.empty()) {
            add_choices(parts);
        }
        return parts;
    }

    void add_field(std::vector<Part> &parts) {
        const int padding = rounded_px(0.5 * attempt_.text_px);
        TextLines typed = wrapped(picture_.typed.empty() ? " " : picture_.typed, typeface_,
                                  attempt_.text_px, column_ - 3 * padding);
        if (typed.lines.size() > kFieldLines) {
            typed.lines.erase(typed.lines.begin(), typed.lines.end() - kFieldLines);
        }
        const int high = static_cast<int>(kFieldLines) * typed.line_height_px + 2 * padding;
        parts.push_back({high, gap_, [this, typed, padding, high](int top) {
                             layout_.field = {(width_ - column_) / 2, top, column_, high};
                             fill_field(typed, padding);
                         }});
    }

    void fill_field(const TextLines &typed, int padding) {
        const PixelBox &field = layout_.field;
        layout_.typed = {{field.x + padding, field.y + padding, typed.width_px, typed.height_px()},
                         typed};
        // After the last letter, and the blanks behind it.
        const std::size_t letters_end = picture_.typed.find_last_not_of(' ');
        const std::string blanks =
            picture_.typed.substr(letters_end == std::string::npos ? 0 : letters_end + 1);
        const int thick = std::max(2, rounded_px(0.08 * attempt_.text_px));
        const int right = field.x + field.width - padding - thick;
        const int at =
            layout_.typed.box.x + typed.lines.back().width_px +
            (picture_.typed.empty() ? 0 : text_width_px(blanks, typeface_, attempt_.text_px)) +
            thick;
        const int last_top =
            field.y + padding + (static_cast<int>(typed.lines.size()) - 1) * typed.line_height_px;
        layout_.cursor = {std::min(at, right), last_top, thick, typed.line_height_px};
    }

    void add_choices(std::vector<Part> &parts) {
        const int widest = rounded_px(kWidestPlate * height_);
        std::optional<ChoicePlates> plates =
            arranged(picture_.choices, typeface_, attempt_.text_px, wide_, widest);
        if (!plates && !attempt_.is_strict) {
            plates = squeezed(picture_.choices, typeface_, attempt_.text_px, wide_, widest);
        }
        if (!plates || plates->choices.empty()) {
            fits_ = false;
            return;
        }
        parts.push_back({plates->height, gap_, [this, plates](int top) {
                             const int left = (width_ - plates->width) / 2;
                             for (const PlacedChoice &choice : plates->choices) {
                                 layout_.choices.push_back(moved(choice, left, top));
                             }
                         }});
    }

    /// In the middle between two heights. @return whether there is room
    static bool place(const std::vector<Part> &parts, int top, int bottom) {
        int high = 0;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            high += parts[i].height + (i > 0 ? parts[i].gap : 0);
        }
        if (high > bottom - top) {
            return false;
        }
        int at = top + (bottom - top - high) / 2;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            at += i > 0 ? parts[i].gap : 0;
            parts[i].place(at);
            at += parts[i].height;
        }
        return true;
    }

    const ParticipantPicture &picture_;
    int width_;
    int height_;
    const Typeface &typeface_;
    Attempt attempt_;
    int margin_;
    int column_; ///< width of text
    int wide_;   ///< width of headings and choices
    int gap_;    ///< between parts
    bool fits_ = true;
    ParticipantLayout layout_;
};

/// From the largest to the least readable sizes, first without broken words.
std::vector<Attempt> readable_attempts(int height) {
    std::vector<Attempt> attempts;
    for (const bool is_strict : {true, false}) {
        for (int i = 0; i <= kSteps; ++i) {
            const double share = static_cast<double>(i) / kSteps;
            attempts.push_back(
                {std::ceil(std::lerp(kMostHeading, kLeastHeadingPerHeight, share) * height),
                 std::ceil(std::lerp(kMostText, kLeastTextPerHeight, share) * height), is_strict});
        }
    }
    return attempts;
}

} // namespace

std::optional<std::size_t> ParticipantLayout::choice_at(double x, double y) const {
    const auto found = std::ranges::find_if(
        choices, [&](const PlacedChoice &choice) { return choice.plate.contains(x, y); });
    return found == choices.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(found - choices.begin()));
}

ParticipantLayout lay_out(const ParticipantPicture &picture, int width, int height,
                          const Typeface &typeface) {
    SPRINGDRIVE_ASSERT(width > 0 && height > 0);
    const std::vector<Attempt> attempts = readable_attempts(height);
    for (const Attempt &attempt : attempts) {
        if (auto layout = Composition(picture, width, height, typeface, attempt).composed()) {
            return *std::move(layout);
        }
    }
    Attempt smaller = attempts.back();
    while (smaller.text_px > kSmallest_px) {
        smaller.text_px = std::min(smaller.text_px - 1.0, std::round(kFurther * smaller.text_px));
        smaller.heading_px =
            std::round(kLeastHeadingPerHeight / kLeastTextPerHeight * smaller.text_px);
        if (auto layout = Composition(picture, width, height, typeface, smaller).composed()) {
            layout->is_readable = false;
            return *std::move(layout);
        }
    }
    ParticipantLayout nothing;
    nothing.is_readable = false;
    return nothing;
}

bool is_readable(const ParticipantPicture &picture, const Typeface &typeface, int width,
                 int height) {
    return lay_out(picture, width, height, typeface).is_readable;
}

} // namespace springdrive::app::study_screen
