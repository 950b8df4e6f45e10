C     V      slip speed [mm/s]
      PARAMETER (V = $speed)
