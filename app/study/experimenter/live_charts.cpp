#include "app/study/experimenter/study_window.h"

#include "app/widgets/widgets.h"
#include "engine/study/protocol/session_plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

/// A frame with axes from `low` to `high`, in ImGui's units.
class Chart {
public:
    Chart(const char *id, ImVec2 size, double x_low, double x_high, double y_low, double y_high)
        : corner_(ImGui::GetCursorScreenPos()), size_(size), x_low_(x_low), x_high_(x_high),
          y_low_(y_low), y_high_(y_high), list_(*ImGui::GetWindowDrawList()) {
        ImGui::Dummy(size);
        ui::enter(id, "plot", "");
        const float margin = 2.6F * ImGui::GetFontSize();
        corner_.x += margin;
        size_.x -= margin + 0.5F * ImGui::GetFontSize();
        corner_.y += 0.4F * ImGui::GetFontSize();
        size_.y -= 1.8F * ImGui::GetFontSize();
        list_.AddRect(corner_, {corner_.x + size_.x, corner_.y + size_.y},
                      ImGui::GetColorU32(ImVec4(0.35F, 0.38F, 0.42F, 1.0F)));
    }

    [[nodiscard]] ImVec2 at(double x, double y) const {
        const auto share = [](double value, double low, double high) {
            return static_cast<float>(
                std::clamp((value - low) / std::max(1e-12, high - low), 0.0, 1.0));
        };
        return {corner_.x + size_.x * share(x, x_low_, x_high_),
                corner_.y + size_.y * (1.0F - share(y, y_low_, y_high_))};
    }

    void label_y(double y, const std::string &text) {
        const ImVec2 place = at(x_low_, y);
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        list_.AddText({place.x - size.x - 4.0F, place.y - 0.5F * size.y},
                      ImGui::GetColorU32(kFaintInk), text.c_str());
    }
    void label_x(double x, const std::string &text) {
        const ImVec2 place = at(x, y_low_);
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        const float left =
            std::clamp(place.x - 0.5F * size.x, corner_.x, corner_.x + size_.x - size.x);
        list_.AddText({left, place.y + 2.0F}, ImGui::GetColorU32(kFaintInk), text.c_str());
    }
    void point(double x, double y, float radius, const ImVec4 &colour, bool is_filled) {
        const ImU32 ink = ImGui::GetColorU32(colour);
        if (is_filled) {
            list_.AddCircleFilled(at(x, y), radius, ink);
        } else {
            list_.AddCircle(at(x, y), radius, ink, 0, 1.5F);
        }
    }
    void line(double x1, double y1, double x2, double y2, const ImVec4 &colour) {
        list_.AddLine(at(x1, y1), at(x2, y2), ImGui::GetColorU32(colour), 1.5F);
    }

private:
    ImVec2 corner_;
    ImVec2 size_;
    double x_low_;
    double x_high_;
    double y_low_;
    double y_high_;
    ImDrawList &list_;
};

void draw_levels(const study::Protocol &protocol, const study::SeriesResult &result, ImVec2 size) {
    const study::Scale scale = study::analysis_family(protocol).scale;
    if (result.trace.empty()) {
        return;
    }
    double low = study::on_scale(scale, result.trace.front().level);
    double high = low;
    for (const study::TracePoint &point : result.trace) {
        low = std::min(low, study::on_scale(scale, point.level));
        high = std::max(high, study::on_scale(scale, point.level));
    }
    const double room = std::max(0.1 * (high - low), 1e-6);
    const auto trials = static_cast<double>(result.trace.size());
    Chart chart("levels", size, 0.0, trials + 1.0, low - room, high + room);
    double x = 0.0;
    for (const study::TracePoint &point : result.trace) {
        x += 1.0;
        const double y = study::on_scale(scale, point.level);
        const ImVec4 &colour = point.outcome.marked ? kWarning : kTransposeMap;
        chart.point(x, y, 0.22F * ImGui::GetFontSize(), colour, point.outcome.positive);
    }
    chart.label_y(low, ui::formatted("{:.3g}", study::level_from(scale, low)));
    if (high > low) {
        chart.label_y(high, ui::formatted("{:.3g}", study::level_from(scale, high)));
    }
    chart.label_x(0.5 * trials,
                  ui::formatted("{} trial{} of this condition; filled: {}", result.trace.size(),
                                result.trace.size() == 1 ? "" : "s",
                                study::is_forced_choice(protocol.task.kind) ? "right" : "yes"));
}

void show_threshold(const study::FittedFunction &fitted) {
    ui::text(kInk, "threshold {:.3g}, 95 % of it from {:.3g} to {:.3g}", fitted.threshold.median,
             fitted.threshold.low, fitted.threshold.high);
    ui::explain("posterior's median and interval, with the usual priors: of the trials so far, to "
                "see where it leads; springdrive study analyse has the results");
}

void draw_function(const study::Protocol &protocol, const study::SeriesResult &result,
                   ImVec2 size) {
    const study::Scale scale = study::analysis_family(protocol).scale;
    const study::FittedFunction &fitted = *result.fitted;
    const double low = study::on_scale(scale, fitted.course.front().level);
    const double high = study::on_scale(scale, fitted.course.back().level);
    Chart chart("function", size, low, high, 0.0, 1.0);
    for (std::size_t i = 0; i + 1 < fitted.course.size(); ++i) {
        const study::FunctionPoint &a = fitted.course[i];
        const study::FunctionPoint &b = fitted.course[i + 1];
        const double x1 = study::on_scale(scale, a.level);
        const double x2 = study::on_scale(scale, b.level);
        chart.line(x1, a.proportion, x2, b.proportion, kInk);
        chart.line(x1, a.low, x2, b.low, kFaintInk);
        chart.line(x1, a.high, x2, b.high, kFaintInk);
    }
    for (const study::LevelCount &count : result.counts) {
        chart.point(
            study::on_scale(scale, count.level), static_cast<double>(count.positive) / count.trials,
            ImGui::GetFontSize() * std::min(0.5F, 0.12F + 0.03F * static_cast<float>(count.trials)),
            kTransposeMap, true);
    }
    chart.label_y(0.0, "0");
    chart.label_y(1.0, "1");
    chart.label_x(low, ui::formatted("{:.3g}", fitted.course.front().level));
    chart.label_x(high, ui::formatted("{:.3g}", fitted.course.back().level));
}

} // namespace

void draw_live_charts(const study::Protocol &protocol, const study::SeriesResult &result) {
    const float line = ImGui::GetTextLineHeightWithSpacing();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const ImVec2 each{0.5F * (room.x - ImGui::GetStyle().ItemSpacing.x),
                      std::max(5.0F * line, room.y - line)};
    if (result.fitted) {
        show_threshold(*result.fitted);
    } else if (result.settings) {
        ui::text(kInk, "mean setting {:.3g}, 95 % of it from {:.3g} to {:.3g}",
                 result.settings->mean, result.settings->low, result.settings->high);
    }
    draw_levels(protocol, result, each);
    if (result.fitted && result.fitted->course.size() >= 2) {
        ImGui::SameLine();
        draw_function(protocol, result, each);
    }
}

void LiveFit::begin(study::Series series) {
    running_ = std::async(std::launch::async,
                          [protocol = protocol_, series = std::move(series)]() mutable {
                              return study::result_of(protocol, std::move(series));
                          });
}

void LiveFit::request(const study::StudyContents &contents, const std::string &participant,
                      std::size_t condition, study::DeviceKind device) {
    for (study::Series &series : study::series_of(protocol_, contents, device)) {
        if (series.participant != participant || series.condition != condition) {
            continue;
        }
        if (running_.valid()) {
            next_ = std::move(series);
        } else {
            begin(std::move(series));
        }
        return;
    }
    latest_.reset(); // none yet in this condition
}

const study::SeriesResult *LiveFit::latest() {
    if (running_.valid() &&
        running_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        latest_ = running_.get();
        if (next_) {
            begin(*std::exchange(next_, std::nullopt));
        }
    }
    return latest_ ? &*latest_ : nullptr;
}

} // namespace springdrive::app::study_screen
