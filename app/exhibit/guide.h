// The tour in the ordinary window: the scripted hand goes through all scenes once, until Escape.
#pragma once

#include "app/exhibit/course.h"
#include "app/exhibit/performer.h"

#include <optional>

namespace springdrive::app::exhibit {

class Guide {
public:
    void begin(const Stagecraft &stage);
    void end(const Stagecraft &stage);
    [[nodiscard]] bool is_on() const { return course_.has_value(); }

    /// Once a frame. @param time_s  by any clock of the window
    void update(const Stagecraft &stage, double time_s);

private:
    std::optional<Course> course_;
    std::optional<Performer> performer_;
    bool had_scene_ = false; ///< that it shows
};

} // namespace springdrive::app::exhibit
