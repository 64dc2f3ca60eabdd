// Written by references.R; R 4.2.2 psyphy 0.2.3 metafor 3.8.1
#pragma once

#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/analysis/summaries.h"

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace springdrive::study {

struct PsyphyFit {
    std::string name;
    FunctionFamily family;
    std::vector<LevelCount> counts;
    std::array<double, 2> guess_range;
    std::array<double, 2> lapse_range;
    double threshold, slope, guess, lapse, deviance;
    double threshold_low, threshold_high; // 95 % by profile, of the fits with given rates
};

struct MetaforGroup {
    std::vector<ParticipantEstimate> estimates;
    double mean, standard_error, low, high, deviation_between, heterogeneity;
};

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// clang-format off
inline const std::vector<PsyphyFit> kPsyphyFits{
    {"weibull, two alternatives", {Shape::weibull, Scale::logarithmic},
     {{0.25, 19, 40}, {0.5, 22, 40}, {1, 27, 40}, {2, 34, 40}, {4, 39, 40}, {8, 40, 40}},
     {0.5, 0.5}, {0, 0},
     1.84808721784, 1.50764704741, 0.5, 0, 0.532724198207, 1.37348641232, 2.47691129959},
    {"weibull, two alternatives, lapses given", {Shape::weibull, Scale::logarithmic},
     {{0.25, 19, 40}, {0.5, 22, 40}, {1, 27, 40}, {2, 34, 40}, {4, 39, 40}, {8, 39, 40}},
     {0.5, 0.5}, {0.02, 0.02},
     1.68960354052, 1.75245530438, 0.5, 0.02, 0.385964314131, 1.24906831746, 2.32130199872},
    {"weibull, two alternatives, lapses fitted", {Shape::weibull, Scale::logarithmic},
     {{0.25, 19, 40}, {0.5, 23, 40}, {1, 31, 40}, {2, 37, 40}, {4, 37, 40}, {8, 38, 40}},
     {0.5, 0.5}, {0, 0.1},
     0.997134989258, 2.64293122484, 0.5, 0.0663369440607, 0.497889837167, kNone, kNone},
    {"logistic, four alternatives", {Shape::logistic, Scale::logarithmic},
     {{0.25, 11, 40}, {0.5, 13, 40}, {1, 21, 40}, {2, 33, 40}, {4, 38, 40}, {8, 39, 40}},
     {0.25, 0.25}, {0.01, 0.01},
     1.22203993047, 2.39181971672, 0.25, 0.01, 0.144298308545, 0.943892854711, 1.56040843549},
    {"normal, yes/no, rates given", {Shape::cumulative_normal, Scale::linear},
     {{-3, 2, 50}, {-1.5, 7, 50}, {-0.5, 18, 50}, {0.5, 33, 50}, {1.5, 44, 50}, {3, 49, 50}},
     {0.02, 0.02}, {0.01, 0.01},
     -0.0296827568342, 0.773005184617, 0.02, 0.01, 0.170018523344, -0.298588569683, 0.235708955163},
    {"normal, yes/no, rates fitted", {Shape::cumulative_normal, Scale::linear},
     {{-6, 6, 50}, {-3, 5, 50}, {-1.5, 7, 50}, {-0.5, 17, 50}, {0.5, 34, 50}, {1.5, 44, 50}, {3, 47, 50}, {6, 48, 50}},
     {0, 0.3}, {0, 0.1},
     0.0820359993418, 1.03175399558, 0.106929823195, 0.0506067331188, 0.420224402737, kNone, kNone},
    {"logistic, yes/no, rates fitted", {Shape::logistic, Scale::linear},
     {{-6, 3, 50}, {-3, 5, 50}, {-1.5, 9, 50}, {-0.5, 19, 50}, {0.5, 33, 50}, {1.5, 42, 50}, {3, 46, 50}, {6, 47, 50}},
     {0, 0.3}, {0, 0.1},
     -0.0658782541802, 1.29524975242, 0.0677318866025, 0.0609380757961, 0.184897444219, kNone, kNone},
    {"normal, two alternatives, few trials", {Shape::cumulative_normal, Scale::logarithmic},
     {{0.25, 4, 8}, {0.5, 3, 8}, {1, 6, 8}, {2, 7, 8}, {4, 8, 8}, {8, 8, 8}},
     {0.5, 0.5}, {0.02, 0.02},
     1.18447240431, 1.99972225694, 0.5, 0.02, 1.69685724573, 0.596833275058, 2.30916794872},
};

inline const std::vector<MetaforGroup> kMetaforGroups{
    {{{0.62, 0.11}, {0.41, 0.09}, {0.95, 0.15}, {0.7, 0.08}, {0.22, 0.12}, {0.81, 0.1}},
     0.613283490024, 0.106283370341, 0.340073388795, 0.886493591253, 0.236449373604, 25.9069735463},
    {{{1.02, 0.1}, {0.97, 0.12}, {1.05, 0.09}, {1, 0.15}, {0.98, 0.11}},
     1.01056360953, 0.0487955667102, 0.875085397183, 1.14604182188, 0, 0.397333172726},
    {{{-0.3, 0.1}, {0.4, 0.2}},
     0.0285714285714, 0.349343407447, -4.41025742968, 4.46740028682, 0.469041575982, 9.8},
};
// clang-format on

} // namespace springdrive::study
