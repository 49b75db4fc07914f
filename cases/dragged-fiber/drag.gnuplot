# Drag of the dragged fiber on the ring and on the center line, over its way through the cells; writes drag.png here.
# make -C cases drag runs both cases and this.
set encoding utf8
set xlabel 'place of the fiber in cells'
set ylabel 'drag / (viscosity · speed · length)'
set grid
set key outside below
set yrange [3:5]
h = 4.0 / 64
length = 0.125
x(t) = (1.9 + t) / h
set terminal pngcairo size 1200,700 font 'sans,16'
set output 'drag.png'
plot 4.192966 title 'Faxén 1946, radius of the fiber' with lines linewidth 2 dashtype 2 linecolor 'black', \
     'dragged-fiber.forces.dat' index 0 using (x($1)):(-$2/length) with lines linewidth 3 title 'ring, auto', \
     '../dragged-fiber-centerline/dragged-fiber-centerline.forces.dat' index 0 using (x($1)):(-$2/length) \
       with lines linewidth 3 title 'center line, penalty 1e5'
set output
