// Stores of all telemetry channels with made-up contents.
#pragma once

#include "engine/record/channel_store.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
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

} // namespace springdrive::testing
