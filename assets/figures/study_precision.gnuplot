# How precisely a threshold is known, over the number of trials; see app/commands/study/study_plan.cpp.
# Columns of precision.csv: trials, minutes, width in the median, and of four of five, on the scale.
set terminal svg size 900,600 font "DejaVu Sans,14" enhanced background rgb "white"
set label 1 heading at screen 0.5,0.96 center noenhanced font ",16"
set label 2 note at screen 0.5,0.92 center noenhanced font ",11" textcolor rgb grey
set tmargin at screen 0.88
set bmargin at screen 0.21
set lmargin at screen 0.11
set rmargin at screen 0.97
set logscale x
set autoscale xfix
set autoscale yfix
set offsets graph 0.03,graph 0.03,graph 0.06,graph 0.06
set xlabel "trials of a participant in a condition" offset 0,0.2
# Where it is however wide the numbers are.
set label 6 width_label at screen 0.02,0.545 center rotate by 90 noenhanced
stats csv using 1 skip 1 nooutput name "trials"
eval log_tics("x", trials_min, trials_max, 14)
set key at screen 0.54,0.055 center center maxrows 1 samplen 2.5 width -6 noenhanced
shown(width) = is_logarithmic ? exp(width) : width
if (is_logarithmic) {
    stats csv using (shown($3)) skip 1 nooutput name "median"
    stats csv using (shown($4)) skip 1 nooutput name "most"
    set logscale y
    eval log_tics("y", median_min, most_max, 18)
}
if (wanted > 0) {
    set arrow 1 from graph 0,first wanted to graph 1,first wanted nohead dashtype 2 linewidth 1.5 linecolor rgb green
    set label 3 sprintf("wanted: %g", wanted) at graph 0.012,first wanted left offset 0,0.6 textcolor rgb green front
}
if (wanted_trials > 0) {
    set arrow 2 from wanted_trials,graph 0 to wanted_trials,first wanted nohead dashtype 2 linewidth 1.5 linecolor rgb green
    set label 4 sprintf("%g trials", wanted_trials) at wanted_trials,graph 0.03 right offset -0.6,0 textcolor rgb green front
}
set arrow 3 from usual_trials,graph 0 to usual_trials,graph 1 nohead dashtype 3 linewidth 1.5 linecolor rgb grey
set label 5 sprintf("the protocol: %g", usual_trials) at usual_trials,graph 0.97 left offset 0.6,0 textcolor rgb grey front
plot csv using 1:(shown($4)) skip 1 with linespoints pointtype 7 pointsize 0.8 linewidth 2 linecolor rgb blue title "four of five studies are as narrow", \
     csv using 1:(shown($3)) skip 1 with linespoints pointtype 6 pointsize 0.8 linewidth 1.5 linecolor rgb vermillion title "the median study is"
