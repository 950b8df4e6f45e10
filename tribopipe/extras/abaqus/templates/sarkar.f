C     Distance slid at the middle of the increment; TIME(1) is the time
C     of the step at its end.
      S = SSTART + V*(TIME(1)-0.5D0*DTIME)
      FMU = AMU*EXP(-S/CMU) + BMU
      RATE = RATE*SQRT(1.0D0+3.0D0*FMU*FMU)
