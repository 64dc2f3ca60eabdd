// What a frame of the view takes of the graphics card.
#pragma once

#include "app/view/gl_objects.h"

#include <cstdint>

namespace springdrive::app {

/// Of one frame, with the passes for its shadows.
struct FrameLoad {
    int draw_calls = 0;
    std::uint64_t primitives = 0; ///< triangles and lines that were sent
    std::uint64_t samples = 0;    ///< that passed the depth test, of all passes
};

/// Measures one frame after the other. The card answers later: a frame is left out while the one
/// before is not answered, so that measuring never waits.
class FrameLoadMeter {
public:
    void begin();
    void end();

    [[nodiscard]] const FrameLoad &latest() const { return latest_; }

private:
    void take_answer();

    Query primitives_;
    Query samples_;
    bool is_asked_ = false;  ///< and not answered
    bool is_within_ = false; ///< a frame that is measured
    int calls_before_ = 0;
    int calls_ = 0; ///< of the frame that is asked for
    FrameLoad latest_;
};

} // namespace springdrive::app
