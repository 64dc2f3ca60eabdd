# Thresholds of all participants and their mean, by condition; see app/commands/study/study_analyse.cpp.
# $participants: panel, number, estimate and its interval; $means: panel, mean and its interval.
# lowest, highest: of all these.
width = 180.0 + 150*(panels < 3 ? 3 : panels)
height = 560.0
set terminal svg size width,height font "DejaVu Sans,13" enhanced background rgb "white"
set label 1 heading at screen 0.5,(height - 25)/height center noenhanced font ",16"
set label 2 note at screen 0.5,(height - 50)/height center noenhanced font ",11" textcolor rgb grey
set tmargin at screen (height - 75)/height
set bmargin at screen 100/height
set lmargin at screen 110/width
set rmargin at screen (width - 25)/width
set xrange [0.5:panels + 0.5]
set xtics ("" 1)
do for [i=1:panels] {
    name = value(sprintf("title_%d", i))
    # A long name takes two lines.
    blank = strlen(name) > 14 ? strstrt(name[8:*], " ") : 0
    if (blank > 0) { name = name[1:7 + blank - 1]."\n".name[7 + blank + 1:*] }
    # A label: in the text of a tic, % begins a format.
    set xtics add ("" i)
    set label 3 + i name at i,graph 0 center offset 0,-1.4 noenhanced
}
# Where it is however wide the numbers are.
set label 3 estimate_label.level_label at screen 18/width,(height + 25)/2/height center rotate by 90 noenhanced
set autoscale yfix
set offsets 0,0,graph 0.05,graph 0.05
if (is_logarithmic) {
    set logscale y
    eval log_tics("y", lowest, highest, 18)
}
set key at screen 0.5,25/height center center maxrows 1 samplen 2 width 2 noenhanced
# Participants side by side, the mean to their right.
x_of(i, number) = i - 0.3 + (highest_number > 1 ? 0.45*(number - 1)/(highest_number - 1) : 0.2)
plot $participants using (x_of($1, $2)):3:4:5 with yerrorbars pointtype 7 pointsize 0.6 linewidth 1 linecolor rgb grey title "participants", \
     $means using ($1 + 0.32):2:3:4 with yerrorbars pointtype 5 pointsize 1 linewidth 2.5 linecolor rgb blue title "mean of the group"
