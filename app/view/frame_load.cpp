#include "app/view/frame_load.h"

namespace springdrive::app {

void FrameLoadMeter::begin() {
    take_answer();
    is_within_ = !is_asked_;
    if (is_within_) {
        calls_before_ = draw_calls();
        glBeginQuery(GL_PRIMITIVES_GENERATED, primitives_.name());
        glBeginQuery(GL_SAMPLES_PASSED, samples_.name());
    }
}

void FrameLoadMeter::end() {
    if (is_within_) {
        glEndQuery(GL_SAMPLES_PASSED);
        glEndQuery(GL_PRIMITIVES_GENERATED);
        calls_ = draw_calls() - calls_before_;
        is_asked_ = true;
        is_within_ = false;
    }
}

void FrameLoadMeter::take_answer() {
    if (!is_asked_) {
        return;
    }
    GLuint is_there = GL_FALSE; // of the samples, which are known last
    glGetQueryObjectuiv(samples_.name(), GL_QUERY_RESULT_AVAILABLE, &is_there);
    if (is_there == GL_FALSE) {
        return;
    }
    GLuint primitives = 0;
    GLuint samples = 0;
    glGetQueryObjectuiv(primitives_.name(), GL_QUERY_RESULT, &primitives);
    glGetQueryObjectuiv(samples_.name(), GL_QUERY_RESULT, &samples);
    latest_ = {calls_, primitives, samples};
    is_asked_ = false;
}

} // namespace springdrive::app
