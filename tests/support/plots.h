// For tests of plots: stores of all telemetry channels with made-up contents, and what a reader of
// XML insists on, as far as SVG files of plots use it.
#pragma once

#include "engine/record/channel_store.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::testing {

[[nodiscard]] inline std::size_t channel(std::string_view name) {
    return session::channel_named(name).value();
}

/// A store at 1 kHz, to which rows are added.
class MadeUpStore {
public:
    explicit MadeUpStore(std::size_t max_bytes = std::size_t{64} << 20)
        : values_(session::channels().size()), store_(values_.size(), max_bytes) {}

    /// Of the next rows: all other channels are 0, or as they were set last.
    double &operator[](std::string_view name) { return values_[channel(name)]; }
    void set_all(double value) { std::ranges::fill(values_, value); }
    [[nodiscard]] std::vector<double> &values() { return values_; }

    void add(int rows = 1) {
        for (int i = 0; i < rows; ++i) {
            store_.add(kTick_s * static_cast<double>(store_.end()), values_);
        }
    }
    /// Rows until that time, which is included.
    void add_until(double time_s) {
        while (kTick_s * static_cast<double>(store_.end()) <= time_s + 0.5 * kTick_s) {
            add();
        }
    }

    [[nodiscard]] const record::ChannelStore &store() const { return store_; }

    static constexpr double kTick_s = 1e-3;

private:
    std::vector<double> values_;
    record::ChannelStore store_;
};

/// Looks through a text once.
class XmlCheck {
public:
    explicit XmlCheck(std::string_view text) : text_(text) {}

    /// Why it is no well-formed XML with finite numbers; empty if it is.
    [[nodiscard]] std::string error() {
        while (error_.empty() && at_ < text_.size()) {
            text_[at_] == '<' ? take_tag() : take_character();
        }
        if (error_.empty() && !open_.empty()) {
            error_ = open_.back() + " is not closed";
        }
        return error_;
    }
    /// Of the part that has been looked at.
    [[nodiscard]] int elements() const { return elements_; }

private:
    void take_character() {
        const char c = text_[at_];
        if (c == '&') {
            for (const std::string_view known : {"&amp;", "&lt;", "&gt;", "&quot;", "&apos;"}) {
                if (text_.substr(at_, known.size()) == known) {
                    at_ += known.size();
                    return;
                }
            }
            error_ = "a bare & at " + std::to_string(at_);
        } else if (static_cast<unsigned char>(c) < ' ' && c != '\n' && c != '\t') {
            error_ = "a control character at " + std::to_string(at_);
        } else if (open_.empty() && std::isspace(static_cast<unsigned char>(c)) == 0) {
            error_ = "text outside of any element at " + std::to_string(at_);
        }
        ++at_;
    }

    std::string name() {
        const std::size_t begin = at_;
        while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 ||
                                      text_[at_] == '-' || text_[at_] == ':')) {
            ++at_;
        }
        return std::string(text_.substr(begin, at_ - begin));
    }

    bool take(std::string_view expected) {
        if (text_.substr(at_, expected.size()) != expected) {
            return false;
        }
        at_ += expected.size();
        return true;
    }

    void take_tag() {
        ++at_;
        if (take("/")) {
            const std::string closed = name();
            if (open_.empty() || open_.back() != closed || !take(">")) {
                error_ = "</" + closed + " closes nothing";
                return;
            }
            open_.pop_back();
            return;
        }
        open_.push_back(name());
        ++elements_;
        if (open_.back().empty()) {
            error_ = "a bare < at " + std::to_string(at_);
        }
        std::set<std::string> attributes;
        while (error_.empty() && at_ < text_.size()) {
            const bool has_space = take(" ");
            if (take("/>")) {
                open_.pop_back();
                return;
            }
            if (take(">")) {
                return;
            }
            const std::string attribute = name();
            if (!has_space || attribute.empty() || !attributes.insert(attribute).second ||
                !take("=\"")) {
                error_ = "no attribute at " + std::to_string(at_);
                return;
            }
            take_attribute_value(attribute);
        }
    }

    void take_attribute_value(const std::string &attribute) {
        const std::size_t end = std::min(text_.find('"', at_), text_.size());
        const std::string value(text_.substr(at_, end - at_));
        at_ = end + 1;
        if (value.find_first_of("<&") != std::string::npos) {
            error_ = "< or & in " + attribute;
        }
        for (const std::string_view number : {"nan", "inf"}) {
            if (value.find(number) != std::string::npos) {
                error_ = attribute + " is \"" + value.substr(0, 200) + '"';
            }
        }
        if (attribute == "id" && !ids_.insert(value).second) {
            error_ = "the id " + value + " twice";
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    std::vector<std::string> open_;
    std::set<std::string> ids_;
    int elements_ = 0;
    std::string error_;
};

[[nodiscard]] inline std::string error_about_xml(std::string_view text) {
    return XmlCheck(text).error();
}

} // namespace springdrive::testing
