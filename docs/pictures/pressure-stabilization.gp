# Draws pressure-stabilization.svg and .png from pressure-stabilization.dat (written by the test pressure_study):
#   cd docs/pictures && gnuplot pressure-stabilization.gp
set logscale xy
set datafile commentschars '#'
set format x "10^{%T}"
set format y "10^{%T}"
set xlabel "{/Symbol m}{/Symbol D}t / ({/Symbol r}h^2)"
set key top right
set grid
set style data linespoints

draw = "set multiplot layout 2,2 title 'Ethier-Steinman flow, 8^3 cells, h fixed: after one step and after ten';"
do for [format in "svg png"] {
  if (format eq "svg") {
    set terminal svg size 1000,800 enhanced font "sans,13" background "white"
  } else {
    set terminal pngcairo size 1000,800 enhanced font "sans,11" background "white"
  }
  set output "pressure-stabilization.".format
  set multiplot layout 2,2 title "Fixed mesh, smaller and smaller time steps (Ethier-Steinman, 8^3 cells)"
  set xrange [1e-6:2]
  set ylabel "pressure, relative L2 error"
  set title "{/Symbol m} = 1, after 1 step"
  plot for [i=0:3] "pressure-stabilization.dat" index i using 2:4 title columnhead(1) pointtype i+4 linewidth 2
  set title "{/Symbol m} = 1, after 10 steps"
  plot for [i=0:3] "pressure-stabilization.dat" index i using 2:10 title columnhead(1) pointtype i+4 linewidth 2
  set title "{/Symbol m} = 1, at the time t = 0.1 {/Symbol r}h^2/{/Symbol m}"
  plot for [i=12:15] "pressure-stabilization.dat" index i using 2:4 title columnhead(1) pointtype i-8 linewidth 2
  set ylabel "velocity, relative L2 error"
  set title "{/Symbol m} = 0.01, after 10 steps"
  plot for [i=4:7] "pressure-stabilization.dat" index i using 2:9 title columnhead(1) pointtype i linewidth 2
  unset multiplot
  set output
}
