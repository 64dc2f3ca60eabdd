// The progress of loading a scene, and its cancellation.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace springdrive::scene {

/// Written by the thread that loads; any thread may read it.
class LoadProgress {
public:
    enum class Stage : std::uint8_t {
        reading,   ///< the file's bytes and structure
        gathering, ///< its triangles
        bending,   ///< smooth nodes
        placing,   ///< in the device's frame
        preparing, ///< the surface for the touch
        measuring, ///< which model the scene gets
    };

    /// @param known whether `advance_to` will be called
    void begin(Stage stage, bool known) noexcept {
        fraction_ = known ? 0.0F : kUnknown;
        stage_ = stage;
    }

    /// @param fraction of the stage, from 0 to 1
    void advance_to(double fraction) noexcept { fraction_ = static_cast<float>(fraction); }

    [[nodiscard]] Stage stage() const noexcept { return stage_; }

    /// For people: "gathering triangles, 40 %".
    [[nodiscard]] std::string text() const;

    /// Cancels loading, from any thread. It ends with Cancelled at its next check, of which there
    /// are many in a second.
    void give_up() noexcept { is_given_up_ = true; }
    /// For the thread that loads, see StopScope.
    [[nodiscard]] const std::atomic<bool> &is_cancelled() const noexcept { return is_given_up_; }

private:
    static constexpr float kUnknown = -1.0F;

    std::atomic<Stage> stage_{Stage::reading};
    std::atomic<float> fraction_{kUnknown};
    std::atomic<bool> is_given_up_{false};
};

} // namespace springdrive::scene
