# Reference fits by psyphy (glm with its links) and metafor, for fits_test.cpp:
#   apt-get install --no-install-recommends r-cran-psyphy r-cran-metafor
#   Rscript tests/engine/study/references.R > tests/engine/study/references.h
suppressPackageStartupMessages({library(psyphy); library(metafor)})

# Given lapse and guess rates, glm finds threshold and slope; both rates by minimising the deviance.
links <- list(cumulative_normal = probit.2asym, logistic = logit.2asym, weibull = weib.2asym)
precise <- glm.control(epsilon = 1e-15, maxit = 500)

glm_at <- function(d, guess, lapse)
  suppressWarnings(glm(cbind(k, n - k) ~ u, binomial(links[[d$shape]](guess, lapse)), d$data,
                       start = d$start, control = precise))
deviance_at <- function(d, rates) deviance(glm_at(d, rates[1], rates[2]))

# With threshold t on the scale; rates are given.
deviance_of_line <- function(d, rates, t, log_slope) {
  x <- d$data
  p <- links[[d$shape]](rates[1], rates[2])$linkinv(exp(log_slope) * (x$u - t))
  sum(binomial()$dev.resids(x$k / x$n, p, x$n))
}
profile_deviance <- function(d, rates, t)
  optimize(function(log_slope) deviance_of_line(d, rates, t, log_slope),
           log(d$start[2]) + c(-4, 4), tol = 1e-10)$objective

fit <- function(name, shape, scale, level, k, n, guess, lapse) {
  u <- if (scale == "logarithmic") log(level) else level
  half <- u[which.min(abs(k / n - (max(k / n) + min(k / n)) / 2))]
  width <- (max(u) - min(u)) / 4
  d <- list(shape = shape, data = data.frame(u = u, k = k, n = n), start = c(-half, 1) / width)
  rates <- c(guess[1], lapse[1])
  if (diff(lapse) > 0 && diff(guess) > 0)
    rates <- optim(c(mean(guess), mean(lapse)) / 2, function(r) deviance_at(d, r),
                   method = "L-BFGS-B", lower = c(guess[1], lapse[1]),
                   upper = c(guess[2], lapse[2]),
                   control = list(factr = 10, pgtol = 0, ndeps = c(1e-6, 1e-6)))$par
  else if (diff(lapse) > 0)
    rates[2] <- optimize(function(l) deviance_at(d, c(guess[1], l)), lapse, tol = 1e-10)$minimum
  best <- glm_at(d, rates[1], rates[2])
  slope <- coef(best)[[2]]
  t <- -coef(best)[[1]] / slope
  least <- deviance(best)
  if (!best$converged) { # glm's steps overshoot with few trials: the same deviance, by optim
    at <- optim(c(t, log(slope)), function(p) deviance_of_line(d, rates, p[1], p[2]), method = "BFGS",
                control = list(reltol = 1e-16, ndeps = c(1e-6, 1e-6), maxit = 1000))
    t <- at$par[1]; slope <- exp(at$par[2]); least <- at$value
  }
  ends <- c(NaN, NaN)
  if (diff(lapse) == 0 && diff(guess) == 0) {
    beyond <- function(x) profile_deviance(d, rates, x) - least - qchisq(0.95, 1)
    ends <- c(uniroot(beyond, c(t - 3 * width, t), tol = 1e-12)$root,
              uniroot(beyond, c(t, t + 3 * width), tol = 1e-12)$root)
  }
  level_of <- if (scale == "logarithmic") exp else identity
  number <- function(x) ifelse(is.nan(x), "kNone", sprintf("%.12g", x))
  cat(sprintf("    {\"%s\", {Shape::%s, Scale::%s},\n     {%s},\n     {%g, %g}, {%g, %g},\n", name,
              shape, scale, paste(sprintf("{%g, %d, %d}", level, k, n), collapse = ", "), guess[1],
              guess[2], lapse[1], lapse[2]))
  cat(sprintf("     %s, %s, %s, %s, %s, %s, %s},\n", number(level_of(t)), number(slope),
              number(rates[1]), number(rates[2]), number(least), number(level_of(ends[1])),
              number(level_of(ends[2]))))
}

group <- function(value, error) {
  g <- rma(yi = value, sei = error, method = "PM", test = "adhoc",
           control = list(tol = 1e-14, maxiter = 1000))
  cat(sprintf("    {{%s},\n     %.12g, %.12g, %.12g, %.12g, %.12g, %.12g},\n",
              paste(sprintf("{%g, %g}", value, error), collapse = ", "), g$beta[1], g$se, g$ci.lb,
              g$ci.ub, sqrt(g$tau2), g$QE))
}

cat("// Written by references.R; R", as.character(getRversion()), "psyphy",
    as.character(packageVersion("psyphy")), "metafor", as.character(packageVersion("metafor")), "\n")
cat('#pragma once

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
')
ratios <- c(0.25, 0.5, 1, 2, 4, 8)
n40 <- rep(40, 6)
fit("weibull, two alternatives", "weibull", "logarithmic", ratios, c(19, 22, 27, 34, 39, 40), n40,
    c(0.5, 0.5), c(0, 0))
fit("weibull, two alternatives, lapses given", "weibull", "logarithmic", ratios,
    c(19, 22, 27, 34, 39, 39), n40, c(0.5, 0.5), c(0.02, 0.02))
fit("weibull, two alternatives, lapses fitted", "weibull", "logarithmic", ratios,
    c(19, 23, 31, 37, 37, 38), n40, c(0.5, 0.5), c(0, 0.1))
fit("logistic, four alternatives", "logistic", "logarithmic", ratios, c(11, 13, 21, 33, 38, 39), n40,
    c(0.25, 0.25), c(0.01, 0.01))
line <- c(-3, -1.5, -0.5, 0.5, 1.5, 3)
n50 <- rep(50, 6)
fit("normal, yes/no, rates given", "cumulative_normal", "linear", line, c(2, 7, 18, 33, 44, 49), n50,
    c(0.02, 0.02), c(0.01, 0.01))
fit("normal, yes/no, rates fitted", "cumulative_normal", "linear", c(-6, line, 6),
    c(6, 5, 7, 17, 34, 44, 47, 48), rep(50, 8), c(0, 0.3), c(0, 0.1))
fit("logistic, yes/no, rates fitted", "logistic", "linear", c(-6, line, 6),
    c(3, 5, 9, 19, 33, 42, 46, 47), rep(50, 8), c(0, 0.3), c(0, 0.1))
fit("normal, two alternatives, few trials", "cumulative_normal", "logarithmic", ratios,
    c(4, 3, 6, 7, 8, 8), rep(8, 6), c(0.5, 0.5), c(0.02, 0.02))
cat("};\n\ninline const std::vector<MetaforGroup> kMetaforGroups{\n")
group(c(0.62, 0.41, 0.95, 0.70, 0.22, 0.81), c(0.11, 0.09, 0.15, 0.08, 0.12, 0.10))
group(c(1.02, 0.97, 1.05, 1.00, 0.98), c(0.10, 0.12, 0.09, 0.15, 0.11))
group(c(-0.3, 0.4), c(0.1, 0.2))
cat("};\n// clang-format on\n\n} // namespace springdrive::study\n")
