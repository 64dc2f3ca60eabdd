# Psychometric functions of one participant, a panel a condition; see app/commands/study/study_analyse.cpp.
# Columns of functions.csv: participant, condition, level, proportion, its interval, maximum
# likelihood's; of levels.csv: participant, condition, level, trials, positive.
columns = panels > 1 ? 2 : 1
rows = (int(panels) + columns - 1)/columns
width = panels > 1 ? 960.0 : 660.0 # of the legend
height = 130.0 + 355*rows
set terminal svg size width,height font "DejaVu Sans,13" enhanced background rgb "white"
set multiplot layout rows,columns margins screen 80/width,(width - 25)/width,95/height,(height - 105)/height spacing screen 95/width,125/height
set label 1 heading at screen 0.5,(height - 25)/height center noenhanced font ",16"
set label 2 note at screen 0.5,(height - 50)/height center noenhanced font ",11" textcolor rgb grey
if (is_logarithmic) { set logscale x }
set xrange [lowest:highest]
set yrange [-0.03:1.03]
set ytics 0.25 format "%.2f"
set xlabel level_label noenhanced offset 0,0.3
set ylabel answers_label noenhanced offset 0.5,0
set key at screen 0.5,25/height center center maxrows 1 samplen 2 width -3 noenhanced
if (is_logarithmic) {
    eval log_tics("x", lowest, highest, 8)
}
size(trials) = 0.35 + 1.5*sqrt(trials/most_trials)
do for [i=1:panels] {
    set label 3 value(sprintf("title_%d", i)) at graph 0.5,1.11 center noenhanced font ",14"
    set label 4 value(sprintf("threshold_text_%d", i)) at graph 0.5,1.045 center noenhanced font ",11" textcolor rgb grey
    f = value(sprintf("functions_first_%d", i))
    l = value(sprintf("functions_last_%d", i))
    p = value(sprintf("levels_first_%d", i))
    q = value(sprintf("levels_last_%d", i))
    t = value(sprintf("threshold_%d", i))
    low = value(sprintf("threshold_low_%d", i))
    high = value(sprintf("threshold_high_%d", i))
    set arrow 1 from t,graph 0 to t,graph 1 nohead linewidth 0.8 dashtype 3 linecolor rgb grey
    set arrow 2 from low,graph 0.02 to high,graph 0.02 nohead linewidth 3 linecolor rgb blue
    plot csv using 3:5:6 skip 1 every ::f::l with filledcurves fillcolor rgb blue fillstyle transparent solid 0.18 noborder title "95 %", \
         chance with lines linewidth 0.8 dashtype 2 linecolor rgb grey notitle, \
         csv using 3:7 skip 1 every ::f::l with lines linewidth 1.5 dashtype 2 linecolor rgb vermillion title "maximum likelihood", \
         csv using 3:4 skip 1 every ::f::l with lines linewidth 2 linecolor rgb blue title "posterior", \
         second_csv using 3:($5/$4):(size($4)) skip 1 every ::p::q with points pointtype 7 pointsize variable linecolor rgb "black" title "trials"
    unset key
    unset label 1
    unset label 2
}
unset multiplot
