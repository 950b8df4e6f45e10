C
      SUBROUTINE TPLINE(NODE,SUMPDL,DTIME,KSTEP,KINC,JMATYP,JGVBLOCK)
C     Integral SUMPDL [N/mm] of the contact pressure along the
C     streamline of a node; 0 for a node that is on none. The pressures
C     of all streamlines are looked up at the first call of an
C     increment, or of another attempt at it. What is kept between calls
C     is the reason for cpus=1.
      INCLUDE 'ABA_PARAM.INC'
      PARAMETER (MAXNOD = 1000000, MAXROW = 200000, MAXLIN = 20000)
      DIMENSION JMATYP(*),JGVBLOCK(*)
      DIMENSION SUMS(MAXLIN)
      COMMON /TPREAL/ DL(MAXROW)
      COMMON /TPINTS/ NODES(MAXROW),LINE(MAXROW),LINEOF(MAXNOD)
      SAVE
      DATA NROWS,LSTEP,LINC,DTLAST /0,0,0,0.0D0/
C
      IF (NROWS.EQ.0) CALL TPREAD(NROWS)
      IF (KSTEP.NE.LSTEP.OR.KINC.NE.LINC.OR.
     *    ABS(DTIME-DTLAST).GT.0.0D0) THEN
        DO 10 I = 1,MAXLIN
          SUMS(I) = 0.0D0
   10   CONTINUE
        DO 20 I = 1,NROWS
          CALL TPPRES(NODES(I),P,JMATYP,JGVBLOCK)
          SUMS(LINE(I)) = SUMS(LINE(I)) + P*DL(I)
   20   CONTINUE
        LSTEP = KSTEP
        LINC = KINC
        DTLAST = DTIME
      END IF
      SUMPDL = 0.0D0
      IF (NODE.GT.MAXNOD) RETURN
      IF (LINEOF(NODE).GT.0) SUMPDL = SUMS(LINEOF(NODE))
      RETURN
      END
C
      SUBROUTINE TPREAD(NROWS)
C     Read streamlines.dat in the folder of the job: the number of rows,
C     then in each row a node, its streamline (1, 2, ...) and the length
C     dl [mm] of the streamline that the node stands for.
      INCLUDE 'ABA_PARAM.INC'
      PARAMETER (MAXNOD = 1000000, MAXROW = 200000, MAXLIN = 20000)
      COMMON /TPREAL/ DL(MAXROW)
      COMMON /TPINTS/ NODES(MAXROW),LINE(MAXROW),LINEOF(MAXNOD)
      SAVE /TPREAL/,/TPINTS/
      CHARACTER*256 OUTDIR
      LOGICAL THERE
C
      CALL GETOUTDIR(OUTDIR,LENDIR)
      INQUIRE(FILE=OUTDIR(1:LENDIR)//'/streamlines.dat',EXIST=THERE)
      IF (.NOT.THERE) THEN
        WRITE(7,*) 'UMESHMOTION: found no streamlines.dat in ',
     *       OUTDIR(1:LENDIR)
        CALL XIT
      END IF
      OPEN(UNIT=105,FILE=OUTDIR(1:LENDIR)//'/streamlines.dat',
     *     STATUS='OLD')
      READ(105,*) NROWS
      IF (NROWS.LT.1.OR.NROWS.GT.MAXROW) THEN
        WRITE(7,*) 'UMESHMOTION: streamlines.dat: found ',NROWS,
     *       ' rows; expected 1 to ',MAXROW
        CALL XIT
      END IF
      DO 10 I = 1,MAXNOD
        LINEOF(I) = 0
   10 CONTINUE
      DO 20 I = 1,NROWS
        READ(105,*) NODES(I),LINE(I),DL(I)
        IF (NODES(I).LT.1.OR.NODES(I).GT.MAXNOD.OR.
     *      LINE(I).LT.1.OR.LINE(I).GT.MAXLIN) THEN
          WRITE(7,*) 'UMESHMOTION: streamlines.dat: found node ',
     *         NODES(I),' on streamline ',LINE(I),
     *         '; expected 1 to ',MAXNOD,' and 1 to ',MAXLIN
          CALL XIT
        END IF
        LINEOF(NODES(I)) = LINE(I)
   20 CONTINUE
      CLOSE(105)
      RETURN
      END
