C     An increment beyond the limit is done again, shorter; none grows
C     beyond it.
      RATIO = 0.9D0*DTMAX/DTIME
      IF (DTIME.LE.DTMAX) RATIO = MAX(RATIO,1.0D0)
      PNEWDT = MIN(PNEWDT,RATIO)
      RETURN
      END
