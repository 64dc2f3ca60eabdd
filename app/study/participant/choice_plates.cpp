#include "app/study/participant/choice_plates.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr std::size_t kMostLinesBeside = 2;
constexpr std::size_t kMostLinesBelow = 3;

int rounded(double length_px) { return static_cast<int>(std::lround(length_px)); }

/// Lengths of a plate, by the size of its text.
struct PlateMeasure {
    explicit PlateMeasure(double text_px)
        : padding(rounded(0.55 * text_px)), gap(rounded(0.6 * text_px)),
          cap(rounded(1.55 * text_px)) {}

    int padding; ///< between a plate's edge and what is in it
    int gap;     ///< between plates, and between a key and its text
    int cap;     ///< height of a key's cap, and its least width
};

enum class KeyPlace : std::uint8_t { beside, above };

/// Arranges all choices in rows of a given number of plates.
class Arrangement {
public:
    Arrangement(std::span<const AnswerChoice> choices, const Typeface &typeface, double text_px,
                int columns, KeyPlace key_place, int most_width, int most_plate_width)
        : choices_(choices), typeface_(typeface), text_px_(text_px), measure_(text_px),
          columns_(columns), key_place_(key_place) {
        for (const AnswerChoice &choice : choices) {
            if (!choice.key.empty()) {
                const int wide =
                    text_width_px(choice.key, typeface, text_px) + 2 * measure_.padding;
                cap_width_ = std::max({cap_width_, measure_.cap, wide});
            }
        }
        plate_width_ =
            std::min(most_plate_width, (most_width - (columns - 1) * measure_.gap) / columns);
        wrap();
    }

    /// Whether there is room for caps and some letters at all.
    [[nodiscard]] bool is_possible() const { return is_possible_; }
    [[nodiscard]] bool keeps_texts_whole() const {
        const std::size_t most_lines =
            key_place_ == KeyPlace::beside ? kMostLinesBeside : kMostLinesBelow;
        return is_possible_ && std::ranges::all_of(texts_, [&](const TextLines &text) {
                   return !text.breaks_words && text.lines.size() <= most_lines;
               });
    }

    [[nodiscard]] ChoicePlates plates() const {
        const int rows = (static_cast<int>(choices_.size()) + columns_ - 1) / columns_;
        const int high = plate_height();
        ChoicePlates result;
        result.width = columns_ * plate_width_ + (columns_ - 1) * measure_.gap;
        result.height = rows * high + (rows - 1) * measure_.gap;
        for (std::size_t i = 0; i < choices_.size(); ++i) {
            const int row = static_cast<int>(i) / columns_;
            const int column = static_cast<int>(i) % columns_;
            const PixelBox plate{column * (plate_width_ + measure_.gap),
                                 row * (high + measure_.gap), plate_width_, high};
            result.choices.push_back(filled(plate, i));
        }
        return result;
    }

private:
    [[nodiscard]] bool has_key(std::size_t i) const { return !choices_[i].key.empty(); }

    void wrap() {
        const int beside =
            key_place_ == KeyPlace::beside && cap_width_ > 0 ? cap_width_ + measure_.gap : 0;
        const int text_width = plate_width_ - 2 * measure_.padding - beside;
        is_possible_ = text_width >= rounded(2.0 * text_px_) &&
                       plate_width_ >= cap_width_ + 2 * measure_.padding;
        if (!is_possible_) {
            return;
        }
        for (const AnswerChoice &choice : choices_) {
            texts_.push_back(
                wrapped(choice.text, typeface_, text_px_, text_width, TextAlign::centre));
        }
    }

    [[nodiscard]] int plate_height() const {
        int high = 0;
        for (std::size_t i = 0; i < choices_.size(); ++i) {
            const int cap = has_key(i) ? measure_.cap : 0;
            const int text = texts_[i].height_px();
            high = std::max(high, key_place_ == KeyPlace::beside
                                      ? std::max(cap, text)
                                      : cap + text + (cap > 0 && text > 0 ? measure_.gap / 2 : 0));
        }
        return high + 2 * measure_.padding;
    }

    /// Key and text as one group in the middle of the plate. Below keys, all texts begin at one
    /// height.
    [[nodiscard]] PlacedChoice filled(const PixelBox &plate, std::size_t i) const {
        PlacedChoice placed{plate, {{}, texts_[i]}, {}, {}};
        const TextLines &text = placed.text.lines;
        const bool is_beside = key_place_ == KeyPlace::beside;
        if (has_key(i)) {
            placed.key_text.lines =
                wrapped(choices_[i].key, typeface_, text_px_, cap_width_, TextAlign::centre);
            const int group = is_beside && !text.lines.empty()
                                  ? cap_width_ + measure_.gap + text.width_px
                                  : cap_width_;
            const PixelBox middle = plate.middle(group, measure_.cap);
            placed.key = {middle.x, is_beside ? middle.y : plate.y + measure_.padding, cap_width_,
                          measure_.cap};
            placed.key_text.box = placed.key.middle(placed.key_text.lines.width_px,
                                                    placed.key_text.lines.height_px());
        }
        if (!text.lines.empty()) {
            PixelBox box = plate.middle(text.width_px, text.height_px());
            if (has_key(i) && is_beside) {
                box.x = placed.key.x + cap_width_ + measure_.gap;
            } else if (has_key(i)) {
                box.y = placed.key.y + measure_.cap + measure_.gap / 2;
            }
            placed.text.box = box;
        }
        return placed;
    }

    std::span<const AnswerChoice> choices_;
    const Typeface &typeface_;
    double text_px_;
    PlateMeasure measure_;
    int columns_;
    KeyPlace key_place_;
    int cap_width_ = 0; ///< of all keys; 0 without any
    int plate_width_ = 0;
    bool is_possible_ = false;
    std::vector<TextLines> texts_;
};

/// Numbers of columns worth trying: those that fill the fewest rows with the fewest plates each.
std::vector<int> column_numbers(std::size_t choices) {
    std::vector<int> columns;
    const int most = static_cast<int>(choices);
    for (int rows = 1; rows <= most; ++rows) {
        const int number = (most + rows - 1) / rows;
        if (columns.empty() || number < columns.back()) {
            columns.push_back(number);
        }
    }
    return columns;
}

} // namespace

std::optional<ChoicePlates> arranged(std::span<const AnswerChoice> choices,
                                     const Typeface &typeface, double text_px, int most_width,
                                     int most_plate_width) {
    for (const int columns : column_numbers(choices.size())) {
        for (const KeyPlace place : {KeyPlace::beside, KeyPlace::above}) {
            const Arrangement arrangement(choices, typeface, text_px, columns, place, most_width,
                                          most_plate_width);
            if (arrangement.keeps_texts_whole()) {
                return arrangement.plates();
            }
        }
    }
    return std::nullopt;
}

ChoicePlates squeezed(std::span<const AnswerChoice> choices, const Typeface &typeface,
                      double text_px, int most_width, int most_plate_width) {
    ChoicePlates lowest;
    for (const int columns : column_numbers(choices.size())) {
        for (const KeyPlace place : {KeyPlace::beside, KeyPlace::above}) {
            const Arrangement arrangement(choices, typeface, text_px, columns, place, most_width,
                                          most_plate_width);
            if (!arrangement.is_possible()) {
                continue;
            }
            ChoicePlates plates = arrangement.plates();
            if (lowest.choices.empty() || plates.height < lowest.height) {
                lowest = std::move(plates);
            }
        }
    }
    return lowest;
}

PlacedText moved(PlacedText text, int right, int down) {
    text.box = text.box.moved(right, down);
    return text;
}

PlacedChoice moved(PlacedChoice choice, int right, int down) {
    choice.plate = choice.plate.moved(right, down);
    choice.key = choice.key.moved(right, down);
    choice.text = moved(std::move(choice.text), right, down);
    choice.key_text = moved(std::move(choice.key_text), right, down);
    return choice;
}

} // namespace springdrive::app::study_screen
