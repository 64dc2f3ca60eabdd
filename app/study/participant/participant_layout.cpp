#include "app/study/participant/participant_layout.h"

#include "base/assertions.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr float kMargin = 1.0F / 16.0F; // of the height, as all below
constexpr float kColumn = 1.25F;        // width of text: some 60 letters a line
constexpr float kWideColumn = 1.6F;     // of headings and choices
constexpr float kMaxCard = 0.62F;
constexpr float kBar = 1.0F / 45.0F; // height of what is left of a break
constexpr float kProgress = 1.0F / 180.0F;
constexpr float kSceneTop = 0.2F;
constexpr float kSceneBottom = 0.72F;

constexpr std::size_t kHeadingLines = 2;
constexpr std::size_t kFieldLines = 4;
constexpr int kReadableSteps = 4; // sizes of text, which is always so many steps below headings:
constexpr int kTextStep = Letters::kSizes - kReadableSteps;
constexpr float kFurther = 0.94F; // a step below the least
constexpr float kMin_px = 2.0F;
constexpr float kHeadingPerText = 1.5F; // there

constexpr float kMaxDot = 1.0F / 15.0F; ///< radius, of the plot's height
constexpr double kAxisMargin = 1.12;    ///< of the axis beyond the levels, a factor

std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

/// Sizes of text, and what is given up for them.
struct Attempt {
    float heading_px;
    float text_px;
    bool is_strict; ///< no word is broken, and a heading has two lines at most
};

std::array<Rectangle *, 4> boxes_of(PlacedChoice &choice) {
    return {&choice.card, &choice.key, &choice.text.box, &choice.key_text.box};
}

/// Things one below the other, from 0; moved to the middle of what is free at the end.
class Column {
public:
    /// @param gap  to what is above
    void add(Rectangle &box, float gap) {
        bottom_ += tops_.empty() ? 0.0F : gap;
        box.corner.y = bottom_;
        tops_.push_back(&box.corner.y);
        bottom_ += box.size.y;
    }
    /// Things whose places from the top are known.
    void add(std::vector<PlacedChoice> &choices, float height, float gap) {
        bottom_ += tops_.empty() ? 0.0F : gap;
        for (PlacedChoice &choice : choices) {
            for (Rectangle *const box : boxes_of(choice)) {
                box->corner.y += bottom_;
                tops_.push_back(&box->corner.y);
            }
        }
        bottom_ += height;
    }
    void leave(float gap) { bottom_ += gap; }

    /// @return whether there is room
    [[nodiscard]] bool settle(float top, float bottom) {
        const float down = std::floor(top + 0.5F * (bottom - top - bottom_));
        for (float *const y : tops_) {
            *y += down;
        }
        return bottom_ <= bottom - top;
    }

private:
    float bottom_ = 0.0F;
    std::vector<float *> tops_;
};

/// Plates of one size, in rows that are filled one after the other.
struct Cards {
    std::vector<PlacedChoice> choices; ///< from 0, 0
    ImVec2 size{};
    bool keeps_texts_whole = true;
};

class PlateMaker {
public:
    PlateMaker(const std::vector<AnswerChoice> &choices, const ImFont &font, float text_px,
               float max_width, float max_card_width)
        : choices_(choices), font_(font), text_px_(text_px), max_width_(max_width),
          max_card_width_(max_card_width), padding_(std::round(0.55F * text_px)),
          gap_(std::round(0.6F * text_px)), cap_(std::round(1.55F * text_px)) {
        for (const AnswerChoice &choice : choices) {
            if (!choice.key.empty()) {
                cap_width_ =
                    std::max({cap_width_, cap_, line(choice.key).box.size.x + 2.0F * padding_});
            }
        }
    }

    /// In as few rows as the texts allow, with keys beside their texts or above them. Nothing if a
    /// text would be broken within a word, or into more than two lines beside its key, or three
    /// below it; where that is allowed, the arrangement of the least height.
    [[nodiscard]] std::optional<Cards> made(bool is_strict) const {
        std::optional<Cards> lowest;
        const std::size_t count = choices_.size();
        for (std::size_t rows = 1; rows <= count; ++rows) {
            const std::size_t columns = (count + rows - 1) / rows;
            for (const bool has_keys_beside : {true, false}) {
                std::optional<Cards> cards = arranged(columns, has_keys_beside);
                if (cards && cards->keeps_texts_whole) {
                    return cards;
                }
                if (cards && !is_strict && (!lowest || cards->size.y < lowest->size.y)) {
                    lowest = std::move(cards);
                }
            }
        }
        return lowest;
    }

private:
    [[nodiscard]] TextLines line(const std::string &text) const {
        return wrapped(text, font_, text_px_, max_width_);
    }

    /// Nothing if there is no room for keys and some letters.
    [[nodiscard]] std::optional<Cards> arranged(std::size_t columns, bool has_keys_beside) const {
        const auto number = static_cast<float>(columns);
        const float width =
            std::min(max_card_width_, std::floor((max_width_ - (number - 1.0F) * gap_) / number));
        const float beside = has_keys_beside && cap_width_ > 0.0F ? cap_width_ + gap_ : 0.0F;
        const float text_width = width - 2.0F * padding_ - beside;
        if (text_width < 2.0F * text_px_ || width < cap_width_ + 2.0F * padding_) {
            return std::nullopt;
        }
        Cards cards;
        float height = 0.0F; // of what is in a plate
        for (const AnswerChoice &choice : choices_) {
            PlacedChoice placed;
            placed.text = wrapped(choice.text, font_, text_px_, text_width);
            if (!choice.key.empty()) {
                placed.key.size = {cap_width_, cap_};
                placed.key_text = line(choice.key);
            }
            const float text = placed.text.box.size.y;
            const float key = placed.key.size.y;
            height = std::max(height, has_keys_beside ? std::max(key, text)
                                      : text > 0.0F   ? text_top(key) + text
                                                      : key);
            cards.keeps_texts_whole = cards.keeps_texts_whole && !placed.text.breaks_words &&
                                      placed.text.lines.size() <= (has_keys_beside ? 2U : 3U);
            cards.choices.push_back(std::move(placed));
        }
        height += 2.0F * padding_;
        for (std::size_t i = 0; i < choices_.size(); ++i) {
            PlacedChoice &placed = cards.choices[i];
            placed.card = {{static_cast<float>(i % columns) * (width + gap_),
                            static_cast<float>(i / columns) * (height + gap_)},
                           {width, height}};
            fill(placed, has_keys_beside);
            cards.size.y = placed.card.corner.y + height;
        }
        cards.size.x = number * (width + gap_) - gap_;
        return cards;
    }

    /// Of a text below a key of that height, which may be 0.
    [[nodiscard]] float text_top(float key) const {
        return key > 0.0F ? key + std::round(0.5F * gap_) : 0.0F;
    }

    /// Key and text as one group in the middle of the plate. Below keys, all texts begin at one
    /// height.
    void fill(PlacedChoice &placed, bool has_keys_beside) const {
        const bool has_key = !is_empty(placed.key);
        put_in_middle(placed.text.box, placed.card);
        put_in_middle(placed.key, placed.card);
        if (has_key && !has_keys_beside) {
            placed.key.corner.y = placed.card.corner.y + padding_;
            placed.text.box.corner.y = placed.key.corner.y + text_top(cap_);
        } else if (has_key && !placed.text.lines.empty()) {
            const float group = cap_width_ + gap_ + placed.text.box.size.x;
            placed.key.corner.x =
                placed.card.corner.x + std::floor(0.5F * (placed.card.size.x - group));
            placed.text.box.corner.x = placed.key.corner.x + cap_width_ + gap_;
        }
        put_in_middle(placed.key_text.box, placed.key);
    }

    static void put_in_middle(Rectangle &box, const Rectangle &around) {
        box.corner = {around.corner.x + std::floor(0.5F * (around.size.x - box.size.x)),
                      around.corner.y + std::floor(0.5F * (around.size.y - box.size.y))};
    }

    const std::vector<AnswerChoice> &choices_;
    const ImFont &font_;
    float text_px_;
    float max_width_;
    float max_card_width_;
    float padding_;          ///< between a plate's edge and what is in it
    float gap_;              ///< between plates, and between a key and its text
    float cap_;              ///< height of a key's cap, and its least width
    float cap_width_ = 0.0F; ///< of all keys; 0 without any
};

class Composition {
public:
    Composition(const ParticipantPicture &picture, int width, int height, const Letters &letters,
                const Attempt &attempt)
        : picture_(picture), width_(static_cast<float>(width)), height_(static_cast<float>(height)),
          letters_(letters), attempt_(attempt), margin_(std::round(kMargin * height_)),
          column_(std::min(width_ - 2.0F * margin_, std::round(kColumn * height_))),
          wide_(std::min(width_ - 2.0F * margin_, std::round(kWideColumn * height_))),
          gap_(std::round(0.9F * attempt.text_px)) {}

    /// Nothing if it does not fit.
    std::optional<ParticipantLayout> composed() {
        if (column_ < 4.0F * attempt_.text_px) {
            return std::nullopt;
        }
        const float bottom = place_foot();
        const float half_gap = std::round(0.5F * gap_);
        const float scene_top = std::round(kSceneTop * height_);
        const float scene_bottom = std::round(kSceneBottom * height_);
        const bool is_split = picture_.scene == SceneShown::scene || picture_.curve;
        Column upper;
        add_words(upper);
        Column lower;
        add_answers(is_split ? lower : upper);
        if (picture_.curve) {
            const Rectangle box{{middle(column_), scene_top}, {column_, scene_bottom - scene_top}};
            layout_.curve = arranged(*picture_.curve, box, letters_.font(small_px()), small_px());
        } else if (is_split) {
            layout_.scene = {{0.0F, scene_top}, {width_, scene_bottom - scene_top}};
        }
        const bool has_room =
            is_split ? upper.settle(std::round(0.5F * margin_), scene_top - half_gap) &&
                           lower.settle(scene_bottom + half_gap, bottom)
                     : upper.settle(margin_, bottom);
        lay_card();
        fill_field();
        return fits_ && has_room ? std::optional(std::move(layout_)) : std::nullopt;
    }

private:
    [[nodiscard]] float middle(float wide) const { return std::floor(0.5F * (width_ - wide)); }

    [[nodiscard]] float small_px() const {
        return std::min(attempt_.text_px, letters_.size_px(Letters::kSizes - 1));
    }

    [[nodiscard]] TextLines lines(const std::string &text, float size_px, float max_width,
                                  float paragraph_gap = 0.0F) {
        TextLines made = wrapped(text, letters_.font(size_px), size_px, max_width, paragraph_gap);
        made.box.corner.x = middle(made.box.size.x);
        fits_ = fits_ && !(attempt_.is_strict && made.breaks_words);
        return made;
    }

    /// Footer and progress. @return where everything else must end
    float place_foot() {
        float bottom = height_ - std::round(0.5F * margin_);
        if (picture_.progress) {
            const float high = std::max(3.0F, std::round(kProgress * height_));
            layout_.progress = {{margin_, bottom - high}, {width_ - 2.0F * margin_, high}};
            bottom -= high + std::round(0.25F * margin_);
        }
        layout_.footer = lines(picture_.footer, small_px(), width_ - 2.0F * margin_);
        bottom -= layout_.footer.box.size.y;
        layout_.footer.box.corner.y = bottom;
        return bottom - std::round(0.5F * gap_);
    }

    /// Heading and text, with room for the plate behind them.
    void add_words(Column &column) {
        const float card = picture_.is_calm_stop ? gap_ : 0.0F;
        column.leave(card);
        if (!picture_.heading.empty()) {
            layout_.heading = lines(picture_.heading, attempt_.heading_px, wide_ - 2.0F * card);
            fits_ = fits_ && !(attempt_.is_strict && layout_.heading.lines.size() > kHeadingLines);
            column.add(layout_.heading.box, 0.0F);
        }
        if (!picture_.text.empty()) { // in the middle where it is short, else flush left
            layout_.text = lines(picture_.text, attempt_.text_px, column_ - 2.0F * card,
                                 std::round(0.5F * attempt_.text_px));
            layout_.text.is_centred = layout_.text.lines.size() <= 2 || picture_.is_calm_stop;
            column.add(layout_.text.box, std::round(0.75F * gap_));
        }
        column.leave(card);
    }

    /// What is left of a break, a free text, choices.
    void add_answers(Column &column) {
        if (picture_.left_share) {
            const float wide = std::min(column_, std::round(0.8F * height_));
            layout_.left_bar = {{middle(wide), 0.0F},
                                {wide, std::max(4.0F, std::round(kBar * height_))}};
            column.add(layout_.left_bar, gap_);
        }
        if (!picture_.left_text.empty()) {
            layout_.left_text = lines(picture_.left_text, attempt_.text_px, column_);
            column.add(layout_.left_text.box, std::round(0.5F * gap_));
        }
        if (picture_.has_text_field) {
            layout_.field = {{middle(column_), 0.0F},
                             {column_, kFieldLines * attempt_.text_px + 2.0F * field_padding()}};
            column.add(layout_.field, gap_);
        }
        if (picture_.choices.empty()) {
            return;
        }
        std::optional<Cards> cards =
            PlateMaker(picture_.choices, letters_.font(attempt_.text_px), attempt_.text_px, wide_,
                       std::round(kMaxCard * height_))
                .made(attempt_.is_strict);
        fits_ = fits_ && cards;
        if (cards) {
            layout_.choices = std::move(cards->choices);
            for (PlacedChoice &choice : layout_.choices) {
                for (Rectangle *const box : boxes_of(choice)) {
                    box->corner.x += middle(cards->size.x);
                }
            }
            column.add(layout_.choices, cards->size.y, gap_);
        }
    }

    /// Behind heading and text.
    void lay_card() {
        if (!picture_.is_calm_stop || (picture_.heading + picture_.text).empty()) {
            return;
        }
        const Rectangle &heading = layout_.heading.box;
        const Rectangle &text = layout_.text.box;
        const float top = (is_empty(heading) ? text : heading).corner.y - gap_;
        const Rectangle &last = is_empty(text) ? heading : text;
        const float wide =
            std::min(std::max(heading.size.x, text.size.x) + 4.0F * gap_, width_ - 2.0F * margin_);
        layout_.calm_plate = {{middle(wide), top},
                              {wide, last.corner.y + last.size.y + gap_ - top}};
    }

    [[nodiscard]] float field_padding() const { return std::round(0.5F * attempt_.text_px); }

    void fill_field() {
        if (!picture_.has_text_field) {
            return;
        }
        const Rectangle &field = layout_.field;
        const float padding = field_padding();
        TextLines &typed = layout_.typed;
        typed =
            wrapped(picture_.typed.empty() ? " " : picture_.typed, letters_.font(attempt_.text_px),
                    attempt_.text_px, column_ - 3.0F * padding);
        while (typed.lines.size() > kFieldLines) {
            typed.lines.erase(typed.lines.begin());
        }
        const float hidden = typed.lines.front().top;
        for (TextLine &line : typed.lines) {
            line.top -= hidden;
        }
        typed.is_centred = false;
        typed.box = {{field.corner.x + padding, field.corner.y + padding},
                     {typed.box.size.x, typed.box.size.y - hidden}};
        const TextLine &last = typed.lines.back();
        const float thick = std::max(2.0F, std::round(0.08F * attempt_.text_px));
        const float right = field.corner.x + field.size.x - padding - thick;
        const float at = typed.box.corner.x + (picture_.typed.empty() ? 0.0F : last.width) + thick;
        layout_.cursor = {{std::min(at, right), typed.box.corner.y + last.top},
                          {thick, attempt_.text_px}};
    }

    const ParticipantPicture &picture_;
    float width_;
    float height_;
    const Letters &letters_;
    Attempt attempt_;
    float margin_;
    float column_; ///< width of text
    float wide_;   ///< width of headings and choices
    float gap_;    ///< between parts
    bool fits_ = true;
    ParticipantLayout layout_;
};

/// From the largest to the least readable sizes, first without broken words; then those that
/// cannot be read.
std::vector<Attempt> attempts(const Letters &letters) {
    std::vector<Attempt> all;
    for (const bool is_strict : {true, false}) {
        for (int step = 0; step < kReadableSteps; ++step) {
            all.push_back({letters.size_px(step), letters.size_px(step + kTextStep), is_strict});
        }
    }
    for (float text_px = all.back().text_px; text_px > kMin_px;) {
        text_px = std::min(text_px - 1.0F, std::round(kFurther * text_px));
        all.push_back({std::round(kHeadingPerText * text_px), text_px, false});
    }
    return all;
}

/// All that is written on it.
std::vector<std::string_view> texts_of(const ParticipantPicture &picture) {
    std::vector<std::string_view> texts{picture.heading, picture.text, picture.typed,
                                        picture.footer, picture.left_text};
    for (const AnswerChoice &choice : picture.choices) {
        texts.insert(texts.end(), {choice.text, choice.key});
    }
    if (picture.curve) {
        texts.insert(texts.end(), {picture.curve->level_label, picture.curve->share_label});
    }
    return texts;
}

} // namespace

float CurveChart::x_px(const OwnCurve &curve, double level) const {
    const double lowest = curve.lowest_level / kAxisMargin;
    const double part =
        std::log(level / lowest) / std::log(curve.highest_level * kAxisMargin / lowest);
    return plot.corner.x + static_cast<float>(part) * plot.size.x;
}

float CurveChart::y_px(double right_share) const {
    return plot.corner.y + static_cast<float>(1.0 - right_share) * plot.size.y;
}

float dot_radius_px(int trials, float height_px) {
    const float share = std::min(1.0F, static_cast<float>(trials) / kFullTrials);
    return kMaxDot * height_px * std::sqrt(share);
}

/// The shares' label is above them, flush left.
CurveChart arranged(const OwnCurve &curve, const Rectangle &box, const ImFont &font,
                    float text_px) {
    SPRINGDRIVE_ASSERT(box.size.x > 0.0F && box.size.y > 0.0F && curve.lowest_level > 0.0 &&
                       curve.lowest_level < curve.highest_level);
    const auto text = [&](const std::string &words) {
        return wrapped(words, font, text_px, 2.0F * box.size.x);
    };
    CurveChart chart;
    const auto add = [&](TextLines label, float x, float y) {
        label.box.corner = {std::floor(x), std::floor(y)};
        chart.labels.push_back(std::move(label));
    };
    const float gap = std::floor(0.35F * text_px);
    const float wide = text(percent(1.0)).box.size.x + gap;
    chart.line_px = std::max(1.0F, std::round(box.size.y / 260.0F));
    chart.plot = {{box.corner.x + wide, box.corner.y + text_px + 2.0F * gap},
                  {box.size.x - wide - text_px, box.size.y - 3.0F * text_px - 4.0F * gap}};
    const Rectangle &plot = chart.plot;
    for (const double share : kNamedShares) {
        TextLines label = text(percent(share));
        const float left = plot.corner.x - gap - label.box.size.x;
        add(std::move(label), left, chart.y_px(share) - 0.5F * text_px);
    }
    add(text(curve.share_label), box.corner.x, box.corner.y);
    for (const double level : curve.ticks) {
        TextLines label = text(fmt::format("{:g}", level));
        const float left = chart.x_px(curve, level) - 0.5F * label.box.size.x;
        add(std::move(label), left, plot.corner.y + plot.size.y + gap);
    }
    TextLines label = text(curve.level_label);
    const float left = plot.corner.x + 0.5F * (plot.size.x - label.box.size.x);
    add(std::move(label), left, box.corner.y + box.size.y - text_px);
    return chart;
}

std::optional<std::size_t> ParticipantLayout::choice_at(double x, double y) const {
    const ImVec2 place{static_cast<float>(x), static_cast<float>(y)};
    const auto found = std::ranges::find_if(
        choices, [&](const PlacedChoice &choice) { return choice.card.contains(place); });
    return found == choices.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(found - choices.begin()));
}

ParticipantLayout lay_out(const ParticipantPicture &picture, int width, int height,
                          Letters &letters) {
    SPRINGDRIVE_ASSERT(width > 0 && height > 0);
    letters.prepare(height, texts_of(picture));
    int tried = 0;
    for (const Attempt &attempt : attempts(letters)) {
        if (auto layout = Composition(picture, width, height, letters, attempt).composed()) {
            layout->is_readable = tried < 2 * kReadableSteps;
            return *std::move(layout);
        }
        ++tried;
    }
    ParticipantLayout nothing;
    nothing.is_readable = false;
    return nothing;
}

bool is_readable(const ParticipantPicture &picture, Letters &letters, int width, int height) {
    return lay_out(picture, width, height, letters).is_readable;
}

} // namespace springdrive::app::study_screen
